"""Pairs of teeth: each contact of two teeth on its own, corners of the tips and deviations included (``contact = "pairs"``)."""
