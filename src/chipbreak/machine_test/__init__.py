"""A short program that shows what a machine makes of blocks, and what its times and traces say of it."""
