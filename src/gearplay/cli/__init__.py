"""Command line: one module per command, joined in `gearplay.cli.main`."""
