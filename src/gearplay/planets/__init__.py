"""Planetary sets: load sharing, motion of planets on their pins, floating members."""
