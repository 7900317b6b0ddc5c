"""Nonlinear analysis: sections, periodic orbits and branches, exponents, classification, basins."""
