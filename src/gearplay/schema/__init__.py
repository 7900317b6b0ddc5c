"""Fields of parts: quantities with units, bounds and messages."""
