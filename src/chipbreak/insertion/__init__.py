"""Where blocks may be inserted into a program, and what has to be as it was after them."""
