"""A mesh: two gears in contact on drive and back flanks."""
