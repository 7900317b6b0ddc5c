"""Sweeps: many cases from one plan, reduced where they are simulated."""
