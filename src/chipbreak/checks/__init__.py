"""Tool checks: which check goes where, with which limit, and how the control is asked for it."""
