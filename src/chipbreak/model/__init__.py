"""What blocks mean: modal groups, positions, operations."""
