"""Studies of published experiments with gearplay's public Python interface."""
