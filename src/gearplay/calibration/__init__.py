"""Calibration: which parameters explain a measurement, which it cannot tell, and which model fits better."""
