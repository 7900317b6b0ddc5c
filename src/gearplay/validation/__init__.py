"""Published numbers that the product reproduces, each with its source, its computation and its tolerance."""
