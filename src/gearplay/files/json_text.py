"""Conversion of numbers to JSON."""

import math
from typing import Any

import numpy as np


def finite(value: Any) -> Any:
    """Return a JSON-able copy in which every number that is not finite is None.

    >>> finite({"a": (1.0, float("nan")), "b": np.float64(2.0)})
    {'a': [1.0, None], 'b': 2.0}
    """
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, dict):
        return {str(key): finite(each) for key, each in value.items()}
    if isinstance(value, (list, tuple)):
        return [finite(each) for each in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
