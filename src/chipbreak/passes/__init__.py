"""The passes: each reads the original program and plans edits; none sees another's work."""
