"""The case: complete input of a simulation, validated and frozen."""

import hashlib
import json
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from functools import cached_property
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal, TypeVar

from pydantic import AfterValidator, ConfigDict, Field, PrivateAttr, ValidationError, model_validator

from gearplay.model.consistency import cross_faults
from gearplay.model.expansion import expanded
from gearplay.model.item_names import distinct
from gearplay.model.policy import LIMITS, Policy, Run
from gearplay.model.torsional_pair import FIELD, PARTS, TorsionalPair
from gearplay.parts.bearing.schema import Bearing
from gearplay.parts.coupling.schema import Coupling
from gearplay.parts.environment import Environment
from gearplay.parts.faults import AnyFault
from gearplay.parts.mesh.drawn_gears import drawn_faults, draws_deviations
from gearplay.parts.mesh.relations import printed_faults
from gearplay.parts.mesh.schema import Mesh
from gearplay.parts.planetary.expansion import set_faults, with_members, without_members
from gearplay.parts.planetary.paths import settable_path, settable_paths
from gearplay.parts.protocol import Holder, Joint
from gearplay.parts.rotor.schema import Rotor
from gearplay.parts.sleeve.schema import Sleeve
from gearplay.parts.support.schema import Support
from gearplay.parts.tables import HOLDERS, JOINTS
from gearplay.schema.fields import (
    Counted,
    FrozenTable,
    Later,
    Listed,
    Measure,
    Name,
    Part,
    RotorName,
    is_absent,
)
from gearplay.vocabulary import quantities as q
from gearplay.vocabulary.errors import NO_VALUE, Fault, InputError, join_path

if TYPE_CHECKING:
    from gearplay.parts.housing.schema import Base
    from gearplay.parts.planetary.schema import Planetary
else:

    def _base() -> type[Part]:
        from gearplay.parts.housing.schema import Base

        return Base

    def _planetary() -> type[Part]:
        from gearplay.parts.planetary.schema import Planetary

        return Planetary

    Base, Planetary = Annotated[Any, Later(_base)], Annotated[Any, Later(_planetary)]

NO_ROTORS: Final = Fault("rotors", NO_VALUE, "must have 1 to 200 entries", "Add or remove entries")

Each = TypeVar("Each", bound=Part)
ByRotor = Annotated[dict[RotorName, Each], Counted(0, 200), AfterValidator(FrozenTable)]
"""Parts by the names of rotors."""

Acceleration = Annotated[float, Measure(q.ACCELERATION, "gravity along this axis")]


class ChangedPaths(tuple[str, ...]):
    """Changed paths of a case; all instances compare equal, so that equality of cases does not depend on their changes."""

    __slots__ = ()

    def __eq__(self, other: object) -> bool:
        return isinstance(other, ChangedPaths)

    def __hash__(self) -> int:
        return 0


class Case(Part):
    """A planar network of rotors, sleeves and meshes, and the run to do with it; `gearplay.load_case` makes one.

    All numbers are SI. The tables `rotors` and `sleeves` keep the order of the file, which is the order of
    the state and of the results.

    Parameters
    ----------
    title
        For people.
    formulation
        "geometric", exact involute flanks, or "as_published", the equations of Han et al. 2021 as printed.
    backlash_model
        "coupled" to the centre distance, or "uncoupled".
    gravity
        Along x and y [m/s^2].
    rotors, sleeves, supports, bearings
        By name; a sleeve, a support or a bearing by the name of the rotor that it holds.
    faults
        Of gears and of bearings.
    base, environment
        Motion of the housing; temperatures.
    meshes, couplings
        What connects rotors.
    planetary
        Planetary sets by name; their rotors, pins and meshes are among those above.
    torsional_pair
        The pair of the literature, from dimensionless numbers; its rotors and mesh are among those above.
    mesh_phases
        "by_position", where the teeth of each mesh stand, or "from_zero".
    accepted
        Paths of fields whose warnings `gearplay.check_case` returns as notes.
    run
        Duration, sampling, ensemble, and how to compute (`Policy`).

    Raises
    ------
    pydantic.ValidationError
        For invalid values; `gearplay.load_case` raises `InputError` with a message instead.

    Examples
    --------
    >>> from gearplay.model.reading import load_case
    >>> case = load_case("han2021")
    >>> list(case.rotors), case.meshes[0].backlash, case.policy.tolerance
    (['pinion', 'ring'], 0.0001, 1e-06)

    """

    model_config = ConfigDict(
        defer_build=False, json_schema_extra=lambda schema: schema["required"].remove("rotors")
    )  # sets have their own

    title: Annotated[
        str, Field(max_length=200, pattern=r"^[^\p{Cc}\p{Cf}]*$", description="title, for people")
    ] = ""
    formulation: Annotated[
        Literal["geometric", "as_published"],
        Field(description="exact involute flanks, or the equations of Han et al. 2021 as printed"),
    ] = "geometric"
    backlash_model: Annotated[
        Literal["coupled", "uncoupled"],
        Field(description="backlash follows the centre distance, or is constant"),
    ] = "coupled"
    gravity: Annotated[tuple[Acceleration, Acceleration], Listed(2, 2, "gravity along x and y")] = (0.0, 0.0)
    rotors: Annotated[ByRotor[Rotor], Field(description="rotors by name")]
    sleeves: Annotated[
        ByRotor[Sleeve], Field(description="sleeves by the name of the rotor they support")
    ] = Field(default_factory=FrozenTable)
    meshes: Annotated[tuple[Mesh, ...], Listed(0, 400, "pairs of gears in mesh")] = ()
    couplings: Annotated[tuple[Coupling, ...], Listed(0, 400, "shafts and couplings between rotors")] = ()
    supports: Annotated[
        ByRotor[Support], Field(description="elastic supports by the name of the rotor they hold")
    ] = Field(default_factory=FrozenTable, exclude_if=is_absent)
    bearings: Annotated[
        ByRotor[Bearing], Field(description="rolling bearings by the name of the rotor they hold")
    ] = Field(default_factory=FrozenTable, exclude_if=is_absent)
    faults: Annotated[
        tuple[AnyFault, ...],
        Listed(0, 62, "faults of parts"),
        Field(exclude_if=is_absent),
    ] = ()
    base: Annotated[Base | None, Field(description="motion of the housing", exclude_if=is_absent)] = None
    environment: Annotated[
        Environment | None,
        Field(description="temperatures and the housing", exclude_if=is_absent),
    ] = None
    planetary: Annotated[
        dict[Name, Planetary],
        Field(description="planetary sets by name, each in one table"),
        Counted(0, 20),
        AfterValidator(FrozenTable),
    ] = Field(default_factory=FrozenTable, exclude_if=is_absent)
    torsional_pair: Annotated[
        TorsionalPair | None,
        Field(
            description="the torsional pair of the literature, from dimensionless numbers",
            exclude_if=is_absent,
        ),
    ] = None
    mesh_phases: Annotated[
        Literal["by_position", "from_zero"],
        Field(
            description="mesh phases at the start: from the places of the gears and their teeth, or all 0",
            exclude_if=lambda given: given == "by_position",
        ),
    ] = "by_position"
    accepted: Annotated[
        tuple[Annotated[str, Field(max_length=200)], ...],
        Listed(0, 200, "paths of fields whose warnings `check` says as notes"),
        Field(exclude_if=is_absent),
    ] = ()
    run: Run

    @model_validator(mode="before")
    @classmethod
    def _expand(cls, given: Any) -> Any:
        if not isinstance(given, Mapping):
            return given
        pair = given.get(FIELD)
        if pair is not None and not any(given.get(name) for name in PARTS):
            with suppress(ValidationError):  # an invalid pair is reported by its own validation
                valid = pair if isinstance(pair, TorsionalPair) else TorsionalPair.model_validate(pair)
                return {**given, **valid.parts(), FIELD: valid}
            return {**given, "rotors": {}}
        return with_members(given)

    @model_validator(mode="after")
    def _check(self) -> "Case":
        if not self.rotors:
            raise InputError(NO_ROTORS)
        self._check_pair()
        with settable_paths(self):
            self._check_parts()
        return self

    def _check_parts(self) -> None:
        """Raise `InputError` for faults between valid parts."""
        faults = [
            *cross_faults(vars(self)),
            *set_faults(self.planetary, self.rotors),
            *printed_faults(self),
        ]
        if self.environment is None:
            rule = "must not be given without an environment, which says at which temperature lengths hold"
            cure = "Add [environment] with a temperature, or remove it"
            faults += [
                Fault(join_path(["rotors", name, "temperature"]), f"{rotor.temperature:g} K", rule, cure)
                for name, rotor in self.rotors.items()
                if rotor.temperature is not None
            ]
        if not faults:
            faults = drawn_faults(self)
        if faults:
            raise InputError(faults)

    def _check_pair(self) -> None:
        """Refuse parts given in addition to a torsional pair that differ from the parts it expands to."""
        if self.torsional_pair is None:
            return
        own = self.torsional_pair.parts()
        rotors = {name: Rotor.model_validate(raw) for name, raw in own["rotors"].items()}
        meshes = tuple(Mesh.model_validate(raw) for raw in own["meshes"])
        if dict(self.rotors) != rotors or self.meshes != meshes:
            rule = "must be left out where rotors and meshes are given, which it replaces"
            raise InputError.of(FIELD, NO_VALUE, rule, "Remove rotors and meshes, or the table")

    _changed: ChangedPaths = PrivateAttr(ChangedPaths())

    @property
    def changed(self) -> tuple[str, ...]:
        """Paths that were changed since the case was read from its file, for titles; not part of the case's identity."""
        return tuple(self._changed)

    def with_changed(self, paths: Iterable[str]) -> "Case":
        """Note changed paths, and return the case itself."""
        self._changed = ChangedPaths(dict.fromkeys([*self._changed, *paths]))
        return self

    @property
    def joints(self) -> tuple[Joint, ...]:
        """Parts that connect rotors, besides meshes."""
        return tuple(joint for name in JOINTS for joint in getattr(self, name))

    def named_joints(self) -> Iterator[tuple[str, str, Joint]]:
        """Yield every part that connects rotors, with its path and its name in results, one for each of those in parallel."""
        for table in JOINTS:
            joints = getattr(self, table)
            for index, (name, joint) in enumerate(
                zip(distinct(j.label for j in joints), joints, strict=True)
            ):
                yield f"{table}.{index}", name, joint

    @property
    def differs_by_member(self) -> bool:
        """Whether the mechanism differs between members: a random record of the housing, or deviations drawn within a class."""
        if self.base is not None and self.base.is_per_member:
            return True
        return draws_deviations(self)

    def holders(self, rotor: str) -> tuple[Holder, ...]:
        """Return the parts that hold a rotor, in the order of `HOLDERS`."""
        return tuple([part for table in HOLDERS if (part := getattr(self, table).get(rotor)) is not None])

    def every_holder(self) -> Iterator[tuple[str, str, Holder]]:
        """Yield every part that holds a rotor, with its table and its rotor."""
        for table in HOLDERS:
            for rotor, part in getattr(self, table).items():
                yield table, rotor, part

    def field_path(self, rotor: str, *fields: str) -> str:
        """Return the path of a field of a rotor, which may be a member of a planetary set."""
        return self.settable_path(join_path(["rotors", rotor, *fields]))

    def settable_path(self, path: str) -> str:
        """Return the path of the field that a user sets for one of a part, which may be of a planetary set."""
        return settable_path(self, path)

    def resolved(self) -> dict[str, Any]:
        """Return every value, defaults included, as a JSON-able dictionary in SI.

        `load_case` reads it back to an equal case. Lists of joints that a case does not use are left out, so that the digest of
        a case does not change when a new kind comes.
        """
        document: dict[str, Any] = without_members(self.model_dump(mode="json"), self.planetary)
        left_out = () if self.torsional_pair is None else PARTS
        return {
            name: value
            for name, value in document.items()
            if (value or name not in JOINTS) and name not in left_out
        }

    @property
    def policy(self) -> Policy:
        """Numerical settings of the case: the fields of its run that describe neither the mechanism nor the record."""
        return Policy.model_construct(**{name: getattr(self.run, name) for name in Policy.model_fields})

    def identity(self) -> dict[str, Any]:
        """Return `resolved` without limits and accepted warnings: the fields that a finished run depends on."""
        document = self.resolved()
        document["run"] |= dict.fromkeys(LIMITS)
        document.pop("accepted", None)
        if any(mesh.angle for mesh in self.meshes) or any(
            r.position and r.position[1] for r in self.rotors.values()
        ):
            document["mesh_phases"] = self.mesh_phases
        return document

    @property
    def operating(self) -> "Case":
        """The case at its temperatures, with the lengths that they leave; itself without an `Environment`."""
        return self if self.environment is None else self._expanded

    def model_copy(self, *, update: Mapping[str, Any] | None = None, deep: bool = False) -> "Case":
        """Return a copy with changed fields, whose expanded form and digest are computed anew."""
        found = super().model_copy(update=update, deep=deep)
        for derived in ("_expanded", "sha256"):
            found.__dict__.pop(derived, None)
        return found

    @cached_property
    def _expanded(self) -> "Case":
        return expanded(self)

    def at_temperature(self, temperature: float) -> "Case":
        """Return the case, which has an `Environment`, with the lengths that another temperature [K] of it leaves."""
        assert self.environment is not None, "checked before"
        environment = self.environment.model_copy(update={"temperature": temperature})
        return expanded(self.model_copy(update={"environment": environment}))

    def _repr_html_(self) -> str:
        from gearplay.model.case_table import case_html

        return case_html(self)

    @cached_property
    def sha256(self) -> str:
        """Digest of the case's `identity`.

        Neither limits, nor the order of fields, nor units, nor defaults that are written out change it; the order of
        rotors and sleeves does, since it is the order of the state.
        """
        text = json.dumps(self.identity(), separators=(",", ":"), allow_nan=False, ensure_ascii=True)
        return hashlib.sha256(text.encode("ascii")).hexdigest()
