"""Variables of a result: those of rotors from the vocabulary, those of elements from their modules."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

from gearplay.parts.registry import KINDS
from gearplay.vocabulary.quantities import ROTOR_VARIABLES, Quantity

VARIABLES: Final[Mapping[str, tuple[Quantity, ...]]] = MappingProxyType(
    {
        "rotor": tuple(ROTOR_VARIABLES.values()),
        **{kind.name: tuple(Quantity(*signal[:6]) for signal in kind.file.SIGNALS) for kind in KINDS},
    }
)
"""Variables by dimension, in the order of a full row of the kernels."""

RESULT_VARIABLES: Final[Mapping[str, Quantity]] = MappingProxyType(
    {quantity.name: quantity for quantities in VARIABLES.values() for quantity in quantities}
)
"""Every result variable, by name."""
