"""Teeth of a gear pair as drawn: geometry, path of contact, stiffness and load sharing over it."""
