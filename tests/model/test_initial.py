"""Where a motion starts: what cannot mesh there is refused before anything runs, given or drawn."""

import numpy as np
import pytest

import gearplay as gp
from gearplay.kernels.layout import vx_of, x_of
from gearplay.model.initial import initial_state
from gearplay.model.pack import pack


@pytest.mark.parametrize("start", ["given", "drawn"])
def test_teeth_that_cannot_mesh_at_the_start_are_refused(start: str) -> None:
    case = gp.load_case("han2021", ["rotors.ring.initial.x=10mm", f"run.start={start}"])
    with pytest.raises(
        gp.InputError, match=r"meshes\.0 .* must be able to mesh at the start\. Move initial\.x"
    ):
        gp.simulate(case, duration=0.01)


@pytest.mark.slow
def test_members_that_are_drawn_are_the_draws_from_the_first_on() -> None:
    given = gp.load_case("han2021")
    drawn = gp.replace(given, {"run.start": "drawn"})
    starts = gp.simulate(drawn, duration=0.001, transient=0.0, ensemble=2, sampling=10_000.0).ds
    packed, ring = pack(given), list(given.rotors).index("ring")
    place, speed = x_of(ring), vx_of(packed.system, ring)
    for member in range(2):
        start = initial_state(given, packed, member=member + 1)
        found = [
            starts[name].sel(rotor="ring").isel(time=0, member=member).item()
            for name in ("x", "y", "vx", "vy")
        ]
        assert found == pytest.approx([*start[place : place + 2], *start[speed : speed + 2]], rel=1e-12)
        assert np.hypot(*found[:2]) > 1e-6
