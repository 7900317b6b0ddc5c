"""Build of the kernel library: compilation of every kernel by numba, linked by the system's linker; no part of a run."""
