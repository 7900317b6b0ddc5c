"""Compiled physics: SI floats and arrays in, SI floats and arrays out; nothing checked, nothing raised.

Symbols follow ISO 21771 in ASCII; signs and phases follow ``docs/conventions.md``; equation numbers are those of
Han et al., Entropy 2021, 23, 834, and of ``docs/theory.md`` where it differs from the article.
"""
