"""Stepping: a case advanced step by step by a caller who holds its inputs."""
