"""What sweeps write: their store, product, pictures and report."""
