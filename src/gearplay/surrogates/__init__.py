"""Surrogates: polynomials fitted to what simulations gave."""
