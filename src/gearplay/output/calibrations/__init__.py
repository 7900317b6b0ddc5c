"""What calibrations write: their store of trials, figures and report, and the conditions read from records."""
