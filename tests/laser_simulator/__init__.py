"""A laser barrier and a cutting tool in front of it, for running tool-check macros without a machine."""
