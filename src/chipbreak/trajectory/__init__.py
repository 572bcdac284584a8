"""What a control makes of blocks in time: one law a kind of control."""
