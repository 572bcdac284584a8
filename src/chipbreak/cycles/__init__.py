"""Roughing and finishing cycles: a cycle and its contour become the passes that the control would make."""
