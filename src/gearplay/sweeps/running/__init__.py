"""Evaluation of the points of a sweep, reduction, storage and assembly."""
