"""The passes: each reads the original program and plans edits; none sees another's work."""

# The names that edits carry.
SPEEDS, VIBRATE, CHECK_TOOLS = "speeds", "vibrate", "check_tools"
