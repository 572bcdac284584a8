"""What is said of a run, drawn: chips, speeds, ramps, times.  Needs the optional extra ``plot``."""
