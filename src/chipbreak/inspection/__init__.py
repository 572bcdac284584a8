"""Traced tool edges: measures, limits and figures."""
