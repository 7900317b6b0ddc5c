"""Number of usable cores."""

import os


def worker_count() -> int:
    """Return how many threads to use: the cores this process may run on."""
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:  # not on every system
        return os.cpu_count() or 1
