"""Calibration of parameters and models against measured records."""
