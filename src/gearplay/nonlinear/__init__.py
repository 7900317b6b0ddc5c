"""Nonlinear analysis: sections, orbits and their branches, exponents, kinds of motion, basins."""
