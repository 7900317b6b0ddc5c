"""Leave to `make mutation` what needs cosmic-ray, or changes how kernels are cached."""

collect_ignore = ["mutants.py", "run.py"]
