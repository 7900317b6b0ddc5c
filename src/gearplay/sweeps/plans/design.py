"""Drawn part of sweep plans: distributions, sampling, correlations."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from gearplay.schema.fields import Listed, Name, Part, Problem, refuse

Text = Annotated[str, Field(min_length=1, max_length=200, pattern=r"^[^\p{Cc}\p{Cf}]*$")]
Bound = float | Text


class Varied(Part):
    """One field of the case, or several that move together.

    ``mode`` "set" puts the value there; "scale" multiplies what the base case has there.
    """

    name: Name
    path: Text
    also: Annotated[tuple[Text, ...], Listed(0, 32, "further fields that get the same value")] = ()
    mode: Literal["set", "scale"] = "set"


class Random(Varied):
    """A parameter that is drawn: every distribution but the normal ones lies between ``low`` and ``high``.

    ``normal`` has ``mean`` and ``deviation`` (standard) and is cut off at ``low`` and ``high`` where they are given;
    ``log-normal`` is the exponential of one, with ``mean`` its median and ``deviation`` that of the natural logarithm;
    ``triangular`` has its ``peak``, the middle if not given.
    """

    distribution: Literal["uniform", "log-uniform", "triangular", "normal", "log-normal"] = "uniform"
    low: Bound | None = None
    high: Bound | None = None
    mean: Bound | None = None
    deviation: Bound | None = None
    peak: Bound | None = None

    @model_validator(mode="after")
    def _check(self) -> Random:
        needed = ("mean", "deviation") if "normal" in self.distribution else ("low", "high")
        allowed = {"low", "high", *needed} | ({"peak"} if self.distribution == "triangular" else set())
        given = {n for n in ("low", "high", "mean", "deviation", "peak") if getattr(self, n) is not None}
        rule = f"a {self.distribution} distribution has {', '.join(sorted(allowed))}"
        problems = [Problem((n,), f"must be given: {rule}", "Add it") for n in needed if n not in given]
        problems += [
            Problem((n,), f"does not belong here: {rule}", "Remove it") for n in sorted(given - allowed)
        ]
        refuse(problems)
        return self


class Correlation(Part):
    """Correlation of the normal scores of two drawn parameters (a Gaussian copula)."""

    between: Annotated[tuple[Name, Name], Listed(2, 2, "two parameters")]
    value: Annotated[float, Field(ge=-1.0, le=1.0)]


class Design(Part):
    """Points drawn together, along one dimension ``sample``.

    ``saltelli`` makes count (parameters + 2) points for Sobol indices; the others ``count``.
    """

    kind: Literal["latin-hypercube", "sobol", "monte-carlo", "saltelli"] = "latin-hypercube"
    count: Annotated[int, Field(ge=1, le=10_000_000)]
    seed: Annotated[int, Field(ge=0, le=2**31 - 1)] = 0
    parameters: Annotated[tuple[Random, ...], Listed(1, 64, "drawn parameters")]
    correlations: Annotated[tuple[Correlation, ...], Listed(0, 2016, "correlations")] = ()

    @model_validator(mode="after")
    def _check(self) -> Design:
        names, problems = [p.name for p in self.parameters], []
        for at, each in enumerate(self.correlations):
            for name in each.between:
                if name not in names:
                    rule = "must be drawn parameters of this design"
                    problems.append(
                        Problem(("correlations", at, "between"), rule, f"Known: {', '.join(names)}")
                    )
        if self.kind == "saltelli" and self.correlations:
            rule = "must be empty for saltelli: Sobol indices need independent parameters"
            problems.append(Problem(("correlations",), rule, "Choose another kind, or remove them"))
        refuse(problems)
        return self
