"""Changes to a program, and the way back.  The only writers of program text."""
