"""Random meshes with one stiffness whose teeth deviate, for the tests of all elements: the envelope over their pairs."""

import math

import numpy as np

from building import Document
from elements import test_pairs

carried = test_pairs.carried


def sample(rng: np.random.Generator, *, damped: bool = True, plain: bool = False) -> Document:
    """Return the pairs of `test_pairs.sample` with one stiffness, a wave or a jump, and teeth that deviate."""
    document = test_pairs.sample(rng, damped=damped, plain=plain)
    (mesh,) = document["meshes"]
    kinds: list[Document] = [
        {"kind": "harmonic", "mean": 1.5e8, "amplitude": 0.0 if plain else 4e7, "phase": 0.4},
        {"kind": "square", "double": 2e8, "single": 1.2e8, "contact_ratio": 1.6},
    ]
    mesh |= {"contact": "mesh", "stiffness": kinds[0 if plain else int(rng.integers(2))]}
    faults = [fault for fault in document["faults"] if fault["kind"] in ("spall", "wear")]
    for name, teeth in (("small", 20), ("large", 60)):
        document["rotors"][name].pop("quality", None)
        # Teeth whose pattern a mirror leaves as it is.
        turned = 5e-6 * np.cos(2.0 * math.pi * np.arange(teeth) / teeth) if not plain else np.zeros(teeth)
        form = {"form": [-2e-6] * teeth} if document["rotors"][name]["helix_angle"] == 0.0 else {}
        document["rotors"][name]["deviations"] = {"pitch": turned.tolist(), **form}
    if plain:
        document["rotors"]["small"]["helix_angle"] = document["rotors"]["large"]["helix_angle"] = 0.0
    return {**document, "faults": faults}
