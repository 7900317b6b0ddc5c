"""Arrays of a netCDF-4 file by name, each with its type and shape checked before it is read."""

from typing import Any

import numpy as np
from numpy.typing import NDArray


class Stored:
    """A group of an HDF5 result file; a missing or mistyped item is a `ValueError`, whose text is a predicate.

    Parameters
    ----------
    group
        Of h5py.

    """

    def __init__(self, group: Any) -> None:
        self.group = group

    def __contains__(self, name: str) -> bool:
        """Return whether there is an object of this name."""
        return name in self.group

    def subgroup(self, name: str) -> "Stored":
        """Return a group."""
        return Stored(self._own(name, "Group"))

    def attribute(self, name: str, kind: type[Any], default: Any = None) -> Any:
        """Return an attribute of a type: ``str``, ``int`` or ``float``."""
        value = self.group.attrs.get(name, default)
        value = value.item() if isinstance(value, np.generic) else value
        if not isinstance(value, kind):
            raise ValueError(f"its attribute {name} is none of {kind.__name__}")
        return value

    def attributes(self) -> dict[str, Any]:
        """Return all attributes."""
        return {name: v.item() if isinstance(v, np.generic) else v for name, v in self.group.attrs.items()}

    def numbers(self, name: str, kind: str, shape: tuple[int | None, ...]) -> NDArray[Any]:
        """Return an array of 64-bit numbers, ``kind`` "i" or "f", of a shape; None leaves a size open."""
        found = self._own(name, "Dataset")
        if found.external or found.is_virtual:
            raise ValueError(f"its array {name} lies elsewhere")
        wanted = "x".join("?" if size is None else str(size) for size in shape)
        fits = len(found.shape or ()) == len(shape) and all(
            size is None or size == own for size, own in zip(shape, found.shape or (), strict=True)
        )
        if found.dtype.kind != kind or found.dtype.itemsize != 8 or not fits:
            raise ValueError(f"its array {name} is not one of {kind}8 of shape {wanted}")
        return np.asarray(found[...]).astype(f"{kind}8")

    def _own(self, name: str, kind: str) -> Any:
        """Return an object stored in this file; links, which may lead to other files, are refused."""
        import h5py

        link = self.group.get(name, getlink=True)
        found = self.group[name] if isinstance(link, h5py.HardLink) else None
        if not isinstance(found, getattr(h5py, kind)):
            raise ValueError(f"it lacks the {kind.lower()} {name}")
        return found
