"""Variance decomposition of a sweep's number."""
