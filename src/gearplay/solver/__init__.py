"""Simulation of a case: trajectories with a status."""
