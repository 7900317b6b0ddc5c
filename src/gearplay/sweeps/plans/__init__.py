"""What a sweep plan says."""
