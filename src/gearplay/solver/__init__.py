"""Simulation: a case, a method and what to keep in; trajectories with a status out."""
