"""A Gymnasium environment: torque in, encoders out, backlash and friction drawn per episode; needs the extra ``gym``."""

from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearplay.model.reading import Source, load_case, replace
from gearplay.stepping.arguments import checked_time
from gearplay.stepping.stepper import Stepper
from gearplay.vocabulary.errors import InputError, SimulationError
from gearplay.vocabulary.optional import load_optional

try:
    _base: Any = import_module("gymnasium").Env
except ModuleNotFoundError:  # making an environment raises with the command that installs it
    _base = object
Floats = NDArray[np.float64]

__all__ = ["GearEnv"]


class GearEnv(_base):  # type: ignore[misc]
    """A case as an environment; an episode ends after ``duration``, or where the integration fails.

    Parameters
    ----------
    case, inputs, outputs
        As of `Stepper`: actions are the inputs, observations the outputs.
    limits
        Lowest and highest value of each input.
    reward
        Function of the observation and the action before it that returns the reward of a step.
    dt, duration
        Length of a step and of an episode [s].
    draw
        Fields of the case that each episode draws evenly between two values: ``{"meshes.0.backlash": (20e-6, 80e-6)}``.

    Raises
    ------
    InputError
        For names that are no inputs, signals or fields, limits that are not rising, and where Gymnasium is not installed.

    """

    metadata: Mapping[str, Any] = {"render_modes": []}  # as its base declares it

    def __init__(
        self,
        case: Source,
        inputs: Sequence[str],
        outputs: Sequence[str],
        limits: Sequence[tuple[float, float]],
        reward: Callable[[Floats, Floats], float],
        *,
        dt: float = 1e-3,
        duration: float = 1.0,
        draw: Mapping[str, tuple[float, float]] | None = None,
    ) -> None:
        spaces = load_optional("gymnasium", "gym").spaces
        self._case, self._reward, self._dt = load_case(case), reward, checked_time(dt)
        self._draw = dict(draw or {})
        self._stepper = Stepper(self._case, inputs=inputs, outputs=outputs)
        bounds = np.array(limits, dtype=np.float64).reshape(-1, 2)
        if len(bounds) != len(inputs) or not np.all(bounds[:, 0] < bounds[:, 1]):
            rule = f"must be a lower and a higher value of each of {len(inputs)} inputs"
            raise InputError.of("limits", list(limits), rule, "Write limits=[(-1.0, 1.0)]")
        self._steps = max(1, round(checked_time(duration) / self._dt)) if self._dt > 0.0 else 1
        self._taken = 0
        self.action_space = spaces.Box(bounds[:, 0], bounds[:, 1], dtype=np.float64)
        shape = (len(self._stepper.outputs),)
        self.observation_space = spaces.Box(-np.inf, np.inf, shape, dtype=np.float64)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Floats, dict[str, Any]]:
        """Begin an episode; return the observation, and the drawn values by their fields."""
        super().reset(seed=seed, options=options)
        drawn = {path: float(self.np_random.uniform(*ends)) for path, ends in self._draw.items()}
        if drawn:
            stepper = self._stepper
            changed = replace(self._case, drawn)
            self._stepper = Stepper(changed, inputs=stepper.inputs, outputs=stepper.outputs)
        self._taken = 0
        return self._stepper.reset(seed=int(self.np_random.integers(2**31))), dict(drawn)

    def step(self, action: Any) -> tuple[Floats, float, bool, bool, dict[str, Any]]:
        """Take a step; return observation, reward, terminated (integration failed), truncated (end of the episode), info."""
        self._taken += 1
        truncated = self._taken >= self._steps
        try:
            found = self._stepper.step(self._dt, action)
        except SimulationError as error:
            return np.zeros(self.observation_space.shape), 0.0, True, truncated, {"message": str(error)}
        return found, float(self._reward(found, np.asarray(action))), False, truncated, {}
