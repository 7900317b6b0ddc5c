"""What is learned from trajectories: spectra, lines, contact statistics, comparison with a published test."""
