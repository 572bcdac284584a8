"""Vibration cutting: what was asked, the plan of each cut, its blocks, and what the output really does."""
