"""netCDF-4 files written variable by variable and block by block, in little memory and without xarray."""

import hashlib
import io
import math
import threading
from collections.abc import Callable, Mapping
from functools import cache, partial
from pathlib import Path
from typing import Any, Final, TypeVar

import numpy as np

from gearplay.files.atomic import LENGTH, MARK, check_new, replacing, with_checksum, write_bytes
from gearplay.vocabulary.background import begin

CHECKSUM: Final = "digest"
"""Attribute of a file that has a digest at its end."""
PART: Final = 1 << 20
SMALL: Final = 4096
"""Numbers of a variable up to which it is stored as it is."""
CHUNK: Final = 1 << 14
"""Times that are compressed together."""
CACHE: Final = 1 << 18
"""Memory of each variable for chunks that are not written yet [bytes]; HDF5 2 would take 8 MB."""
IN_MEMORY: Final = 2e7
"""Size [bytes] of a file that is made in memory and written at once, which is faster."""
LEAST_PACKED: Final = 0.05
"""Smallest size of a file relative to its numbers; about a fifth is usual."""
Made = TypeVar("Made")


class StoppedError(Exception):
    """Raised inside the writer when the caller was interrupted; the caller does not get it."""


class Writer:
    """A group of a netCDF-4 file that is being written: dimensions are scales of HDF5.

    Parameters
    ----------
    group
        Of h5py.
    stop
        Set where the caller was interrupted: the next call raises `StoppedError`.

    """

    def __init__(self, group: Any, stop: threading.Event) -> None:
        self.group, self.stop = group, stop
        self.scales: dict[str, Any] = {}
        self.made: dict[str, Any] = {}

    def subgroup(self, name: str) -> "Writer":
        """Create a group."""
        return Writer(self.group.create_group(name), self.stop)

    def attributes(self, values: Mapping[str, Any]) -> None:
        """Set attributes of the group."""
        for name, value in values.items():
            _set(self.group.id, name, value)

    def variable(
        self,
        name: str,
        dims: tuple[str, ...],
        shape: tuple[int, ...],
        dtype: Any,
        attributes: Mapping[str, Any],
        *,
        values: Any = None,
    ) -> None:
        """Create a variable, with ``values`` where they are given; without ``dims`` it is no variable of netCDF."""
        import h5py
        from h5py import h5d, h5ds, h5s, h5t

        kind = np.dtype(dtype)
        how: dict[str, Any] = {}
        if kind.kind in "fi" and math.prod(shape) > SMALL:
            how = {"compression": "gzip", "compression_opts": 1, "shuffle": True}
            sizes = {"member": 1, "time": CHUNK}
            own = tuple(min(sizes.get(dim, n), n) for dim, n in zip(dims, shape, strict=False))
            how["chunks"] = own or True
        if (
            values is not None and not how and kind.kind in "fi"
        ):  # with less ado than h5py's: there are dozens
            values = np.ascontiguousarray(values)
            made = h5d.create(self.group.id, name.encode(), h5t.py_create(kind), h5s.create_simple(shape))
            made.write(h5s.ALL, h5s.ALL, values)
        else:
            stored = h5py.string_dtype() if kind.kind in "OU" else kind
            values = values.astype(object) if kind.kind == "U" else values
            empty = {"f": np.nan, "i": -1}.get(
                kind.kind
            )  # a member that stopped early is not filled to the end
            self.made[name] = self.group.create_dataset(name, shape, stored, values, fillvalue=empty, **how)
            made = self.made[name].id
        for key, value in attributes.items():
            _set(made, key, value)
        if dims == (name,):
            h5ds.set_scale(made, name.encode())
            self.scales[name] = made
            return
        for at, dim in enumerate(dims):
            h5ds.attach_scale(made, self._scale(dim, shape[at]), at)

    def _scale(self, dim: str, size: int) -> Any:
        """Return the scale of a dimension, a new one without values where it is no variable."""
        if dim not in self.scales:
            scale = self.group.create_dataset(dim, (size,), ">f4")
            scale.make_scale(f"This is a netCDF dimension but not a netCDF variable. {size:>9}")
            self.scales[dim] = scale.id
        return self.scales[dim]

    def put(self, name: str, place: Any, values: Any) -> None:
        """Write values into a part of a variable."""
        if self.stop.is_set():
            raise StoppedError
        self.made[name][place] = values

    def table(self, name: str, dims: tuple[str, ...], values: Any, attributes: Mapping[str, Any]) -> None:
        """Create a variable with all its values."""
        values = np.asarray(values)
        self.variable(name, dims, values.shape, values.dtype, attributes, values=values)


def _set(owner: Any, name: str, value: Any) -> None:
    """Set a new attribute of an object by its identifier."""
    from h5py import h5a, h5s, h5t

    if isinstance(value, str):  # with less ado than h5py's: there are more than a hundred
        text, kind, space = _text_types()
        value = np.array(value, dtype=text)
    else:
        value = np.asarray(value)
        kind, space = (
            h5t.py_create(value.dtype),
            h5s.create_simple(value.shape) if value.ndim else h5s.create(h5s.SCALAR),
        )
    h5a.create(owner, name.encode("utf-8"), kind, space).write(value)


@cache
def _text_types() -> tuple[Any, Any, Any]:
    """Return the types of a text in NumPy and in HDF5, and the shape of a single one."""
    from h5py import h5s, h5t, string_dtype

    return string_dtype(), h5t.py_create(string_dtype(), logical=True), h5s.create(h5s.SCALAR)


class _Disk(io.FileIO):
    """File object whose writes never fail, since HDF5 may crash on a failed one: a full disk sets ``stop`` and ``error``."""

    def __init__(self, path: Path, stop: threading.Event) -> None:
        super().__init__(path, "r+")
        self.stop = stop
        self.error: OSError | None = None

    def write(self, data: Any) -> int:
        """Write the complete buffer, or store the error."""
        left = memoryview(data).cast("B")
        size = left.nbytes
        while left.nbytes and self.error is None:
            try:
                left = left[super().write(left) :]
            except OSError as error:
                self.error = error
                self.stop.set()
        return size

    def readinto(self, buffer: Any) -> int:
        """Read into a buffer; zeros beyond the end of the file."""
        view = memoryview(buffer).cast("B")
        got = super().readinto(view)
        view[got:] = bytes(view.nbytes - got)
        return view.nbytes


def write_streamed(
    path: Path, make: Callable[[Writer], None], *, overwrite: bool = False, size: float = 0.0
) -> None:
    """Write a netCDF-4 file atomically through ``make(root group)``, with a digest at its end; its numbers are ``size`` bytes.

    The work is done on a thread, so that Ctrl-C comes between calls of HDF5; nothing is written then.

    Raises `InputError` as `gearplay.files.atomic.replacing`, and what ``make`` raises.
    """
    check_new(path, overwrite=overwrite, size=LEAST_PACKED * size)
    stop = threading.Event()
    if size < IN_MEMORY:
        content = _on_thread(partial(_content, make, stop), stop)
        check_new(path, overwrite=overwrite, size=len(content))
        write_bytes(path, content, overwrite=overwrite)
        return
    with replacing(path, overwrite=overwrite) as temporary:
        _on_thread(partial(_write, temporary, make, stop), stop)


def _on_thread(work: Callable[[], Made], stop: threading.Event) -> Made:
    """Return the result of ``work()`` on a thread; after Ctrl-C ``stop`` is set and the thread has ended."""
    done = begin(work)
    try:
        return done.result()
    except KeyboardInterrupt:
        stop.set()
        done.exception()
        raise


def _fill(file: Any, make: Callable[[Writer], None], stop: threading.Event) -> None:
    file.attrs[CHECKSUM] = f"sha256 of all bytes before the last {LENGTH}"
    make(Writer(file, stop))


def _content(make: Callable[[Writer], None], stop: threading.Event) -> bytes:
    """Return the content of a small file."""
    import h5py

    with h5py.File("run.nc", "w", driver="core", backing_store=False) as file:
        _fill(file, make, stop)
        file.flush()
        return with_checksum(file.id.get_file_image())


def _write(path: Path, make: Callable[[Writer], None], stop: threading.Event) -> None:
    """Write a large file."""
    import h5py

    with _Disk(path, stop) as disk:
        try:
            with h5py.File(disk, "w", rdcc_nbytes=CACHE) as file:
                _fill(file, make, stop)
        finally:
            if disk.error is not None:
                raise disk.error
    digest = hashlib.sha256()
    with open(path, "rb+") as whole:
        while part := whole.read(PART):
            if stop.is_set():
                raise StoppedError
            digest.update(part)
        whole.write(MARK + digest.digest())
