"""The power that meshes, sleeves and couplings lose is at no instant below zero."""

import numpy as np
import pytest

import gearplay as gp
from building import Document
from depth import sized
from random_trains import train


def rubbing(seed: int) -> Document:
    """Return a random train with friction in every mesh and nothing else that meshes could lose."""
    rng = np.random.default_rng([44, seed])
    document = train(rng, float(10.0 ** rng.uniform(-9.0, -3.0)), friction=True)
    for mesh in document["meshes"]:
        mesh.pop("damping", None)
    return document


@pytest.mark.slow
def test_friction_of_the_teeth_never_drives() -> None:
    """Without damping all that a mesh loses is friction's: at least 0 in every sample of random trains, and some in many."""
    some = 0
    for seed in range(sized(300, 40, torture=2000)):
        ds = gp.simulate(gp.load_case(rubbing(seed)), threads=1).ds
        lost = ds.mesh_power_loss.values
        moved = np.abs(ds.drive_force.values) * 10.0  # W, at 10 m/s
        assert (lost >= -1e-12 * moved - 1e-15).all(), (seed, float(lost.min()))
        some += bool((lost > 0.0).any())
    assert some > 0.5 * sized(300, 40)


@pytest.mark.slow
def test_no_contact_of_the_geometric_formulation_creates_energy() -> None:
    """Every sample of every lost power of random trains is at least 0, but for rounding beside what passes."""
    for seed in range(sized(200, 20)):
        rng = np.random.default_rng([45, seed])
        result = gp.simulate(gp.load_case(train(rng, 1e-8)), threads=1)
        for name in ("mesh_power_loss", "sleeve_power_loss", "coupling_power_loss"):
            if name in result.ds:
                lost = result.ds[name].values
                assert (lost >= -1e-9 * np.abs(lost).max(initial=0.0) - 1e-12).all(), (seed, name)
