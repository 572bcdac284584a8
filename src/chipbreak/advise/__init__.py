"""Conditions for a cut that is not yet programmed: N, f, S and stroke that break its chips on a machine."""
