"""Results whose fields are variables of their dataset: written and read by one table each."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Self

import numpy as np

from gearplay.model.case import Case
from gearplay.results.base import Answer, case_in, check_kind
from gearplay.results.provenance import provenance
from gearplay.vocabulary.errors import Fault, InputError

if TYPE_CHECKING:
    import xarray as xr


class Column(NamedTuple):
    """Column of one field in the dataset: its dimensions, unit and long name."""

    dims: tuple[str, ...]
    unit: str
    words: str


class Tabled(Answer):
    """An answer with a ``case``: fields named in ``VARIABLES`` are arrays of its dataset, those in ``SCALARS`` attributes.

    ``SCALARS`` says for each what makes the field of an attribute; what is no number or text is written as JSON. Complex fields
    have a last dimension ``part``, real and imaginary.
    """

    VARIABLES: ClassVar[Mapping[str, Column]]
    SCALARS: ClassVar[Mapping[str, Callable[[Any], Any]]] = {}
    case: Case

    @property
    def ds(self) -> xr.Dataset:
        """The numbers as a dataset, SI."""
        import xarray as xr

        variables: dict[str, Any] = {}
        for name, (dims, unit, words) in self.VARIABLES.items():
            values = np.asarray(getattr(self, name))
            if values.dtype.kind == "c":
                values, dims = np.stack([values.real, values.imag], axis=-1), (*dims, "part")
            if values.dtype.kind == "b":
                values = values.astype(np.int8)
            if values.dtype.kind == "U":
                values = values.astype(object)
            variables[name] = (
                dims,
                values,
                {"units": unit, "long_name": words} if unit else {"long_name": words},
            )
        scalars = {name: _attribute(getattr(self, name)) for name in self.SCALARS}
        return xr.Dataset(variables, attrs=provenance(self.case, **scalars))

    @classmethod
    def from_dataset(cls, dataset: xr.Dataset) -> Self:
        """Return the object whose ``ds`` it was; `InputError` where something is missing."""
        check_kind(dataset, cls.answer)
        fields: dict[str, Any] = {}
        try:
            for name in cls.VARIABLES:
                values = dataset[name].values
                fields[name] = (
                    values[..., 0] + 1j * values[..., 1] if "part" in dataset[name].dims else values
                )
            fields |= {name: make(dataset.attrs[name]) for name, make in cls.SCALARS.items()}
        except (KeyError, ValueError) as error:
            rule = f"must be what is written of a {cls.answer}"
            raise InputError(Fault("dataset", str(error), rule, "Write it again")) from None
        return cls(**fields | {"case": case_in(dataset)})


def _attribute(value: Any) -> Any:
    return (
        value if isinstance(value, (int, float, str)) and not isinstance(value, bool) else json.dumps(value)
    )
