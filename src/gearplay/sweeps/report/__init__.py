"""Report of a sweep and its figures."""
