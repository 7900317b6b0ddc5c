"""Elements between bodies, and between bodies and ground: one module per kind, listed in `table`."""
