"""Shared vocabulary: errors and the table of quantities.

This floor imports nothing else of the package.
"""
