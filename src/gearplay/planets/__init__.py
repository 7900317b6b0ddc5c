"""Planetary sets: how planets share the load, how they move on their pins, what floats."""
