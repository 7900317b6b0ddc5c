"""Tolerance answers of a sweep: yield, allowable range, sensitivities."""
