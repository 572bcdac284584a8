"""What is said of a run: one typed model, and its printers."""
