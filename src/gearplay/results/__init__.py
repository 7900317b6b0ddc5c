"""Results: trajectories as a dataset, spectra, figures."""
