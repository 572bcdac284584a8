"""Bytes, lines, places and findings."""
