"""Surrogate models: polynomials fitted to simulations."""
