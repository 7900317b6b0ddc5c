"""Speed, measured: `python -m bench` prints the ratios that docs/performance.md quotes."""
