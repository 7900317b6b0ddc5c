"""A shaft or coupling between two rotors."""
