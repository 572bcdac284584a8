"""Many programs at once: which ones, by whom they are filtered, and what became of each."""
