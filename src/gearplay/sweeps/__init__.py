"""Sweeps: many cases of one plan, reductions, tolerances, reports."""
