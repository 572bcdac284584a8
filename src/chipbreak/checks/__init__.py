"""Tool checks: which check stands where, with which limit, and how the control is asked for it."""
