"""Wear over life: Archard's law on flanks and plain bearings, quasi-static between simulated blocks."""
