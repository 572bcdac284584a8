"""Text to blocks, without losing a byte."""
