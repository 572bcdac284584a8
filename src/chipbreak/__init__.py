"""chipbreak: a G-code filter that breaks chips and watches tools."""
