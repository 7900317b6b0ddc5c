"""Periodic orbits, their branches and bifurcations."""
