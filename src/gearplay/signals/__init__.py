"""Signals, simulated or measured: records, spectra, lines, orders, averages."""
