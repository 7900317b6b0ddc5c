"""Sweeps: many cases of one plan, what is kept of each, tolerances, and the pages that show it."""
