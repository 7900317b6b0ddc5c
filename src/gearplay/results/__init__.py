"""What a run gives: its trajectories as a dataset, its spectrum, its pictures."""
