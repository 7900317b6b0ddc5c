"""Frequency of the article's claimed patterns over ranges of its unknown parameters."""
