"""What a machine's own files say of it: the start of a profile."""
