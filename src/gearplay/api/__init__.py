"""The Python doors of what is above results."""
