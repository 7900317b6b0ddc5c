"""Sweep plans."""
