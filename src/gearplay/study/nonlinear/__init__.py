"""Nonlinear analysis: sections, exponents, orbits, branches, and what kind of motion a response is."""
