"""Motion of the housing."""
