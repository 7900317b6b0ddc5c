"""Cases of a plan and their names."""
