"""A control, a pass and a tool reader that chipbreak finds by the entry points of this package."""
