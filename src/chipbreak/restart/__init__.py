"""Starting again in the middle of a program: where that is possible, and the block that must come first."""
