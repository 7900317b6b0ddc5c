"""A plain bearing (sleeve): a journal in a bush with radial clearance."""
