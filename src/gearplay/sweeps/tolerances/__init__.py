"""Tolerance analysis of a sweep: yield, allowable range, sensitivities."""
