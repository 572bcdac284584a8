"""The passes: each reads the original program and plans edits; none sees another's work."""

# The names that edits carry.
SPEEDS, CHECK_TOOLS = "speeds", "check_tools"
