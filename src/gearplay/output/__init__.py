"""Results on disk and in pictures: datasets, files, plots, reports."""
