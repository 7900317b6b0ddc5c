"""Meshes whose pairs of teeth are shown; the forces are those of `elements.test_pairs`."""

from elements.test_pairs import carried, sample

__all__ = ["carried", "sample"]
