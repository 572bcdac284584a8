"""A second reader of Fanuc's words, written from the makers' manuals and knowing nothing of the package."""
