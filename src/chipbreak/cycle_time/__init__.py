"""How long a program runs as it is written: feeds, rapids, dwells, tool changes, cycles."""
