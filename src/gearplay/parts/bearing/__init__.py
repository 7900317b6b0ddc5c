"""A rolling bearing: balls or rollers between two rings, each a one-sided contact that travels with the cage."""
