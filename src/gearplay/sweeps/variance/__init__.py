"""Where the variance of a sweep's number comes from: the one definition of which parameter matters."""
