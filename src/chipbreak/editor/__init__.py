"""A program as one types it: what is wrong with it, what a cut does, and what may be written instead."""
