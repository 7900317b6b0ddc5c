"""Parameters of the study, each with its source: article, formula, or assumption."""

import math
from dataclasses import dataclass

from gearplay.kernels.elements.table import MESH, SLEEVE
from gearplay.kernels.tooth_stiffness import STIFFNESS_FOURIER
from gearplay.model import geometry
from gearplay.model.case import Case
from gearplay.model.contact_laws import delivered_restitution
from gearplay.model.pack import Packed

ARTICLE = "article, Table 2"
FITTED = "fitted to the test"
STANDARD_GRAVITY = 9.80665  # m/s^2


@dataclass(frozen=True)
class Assumption:
    """One parameter: name, value in words, source ("assumed" where the article is silent)."""

    parameter: str
    value: str
    source: str


def _um(value: float) -> str:
    return f"{1e6 * value:.4g} µm"


def assumptions(case: Case, packed: Packed, *, calibrated: bool) -> list[Assumption]:
    """Return the table of parameters of a `han2021`-like case; with ``calibrated`` what was free is said to be fitted."""
    free = FITTED if calibrated else "assumed"
    pinion, ring, mesh, sleeve = (
        case.rotors["pinion"],
        case.rotors["ring"],
        case.meshes[0],
        case.sleeves["ring"],
    )
    packed_mesh, packed_sleeve = packed.system.records[MESH][0], packed.system.records[SLEEVE][0]
    gyration = [math.sqrt(r.inertia / r.mass) for r in (pinion, ring)]
    swing = (
        math.hypot(*packed.system.terms[packed_mesh.stiffness_start, 1:])
        if packed_mesh.stiffness_count
        else 0.0
    )
    errors = " + ".join(f"{_um(t.amplitude)} of order {t.order}" for t in mesh.transmission_error) or "none"
    assert packed_mesh.stiffness_kind == STIFFNESS_FOURIER
    return [
        Assumption("teeth, module, pressure angle", "20 / 60 internal, 4 mm, 20°", ARTICLE),
        Assumption("masses", f"{pinion.mass:g} kg, {ring.mass:g} kg", ARTICLE),
        Assumption(
            "moments of inertia",
            f"{pinion.inertia:.4g} and {ring.inertia:.4g} kg m² (radii of gyration {gyration[0]:.3f} and {gyration[1]:.3f} m)",
            f"{ARTICLE}; the printed values do not fit pitch radii of 0.040 and 0.120 m"
            if case.rotors["pinion"].inertia > 1e-2
            else "solid disc and annulus from the geometry",
        ),
        Assumption(
            "speeds, radial clearances, backlashes",
            "Tables 3-6",
            "article; only the driven gear's sleeve has clearance",
        ),
        Assumption(
            "contact ratio",
            f"{geometry.mesh_contact_ratio(case, 0):.3f}",
            "full-depth teeth at the nominal centre distance",
        ),
        Assumption(
            "mesh stiffness",
            f"{packed_mesh.k_m:.4g} N/m, amplitude {swing / packed_mesh.k_m:.3g} of it",
            "assumed: 6 mm of steel, ISO 6336-1 B",
        ),
        Assumption(
            "mesh damping",
            f"C_m = {packed_mesh.C_m:.4g} N s/m, full from {_um(packed_mesh.depth)}",
            "assumed",
        ),
        Assumption(
            "sleeve stiffness",
            f"{packed_sleeve.stiffness:.4g} N/m^1.5 at this clearance",
            "assumed shaft radius and steel, (9)",
        ),
        Assumption(
            "sleeve restitution",
            f"{sleeve.restitution:.4g} in {sleeve.law}; delivers {delivered_restitution(packed_sleeve.dissipation):.4f}"
            f" from {1e3 * sleeve.minimum_impact_speed:.3g} mm/s on, more below",
            free,
        ),
        Assumption(
            "drag on the ring",
            f"{ring.load.drag:.4g} N m s/rad",
            FITTED if calibrated else "the one constant fitted, to the six measured f_r",
        ),
        Assumption(
            "static transmission error",
            errors,
            FITTED if calibrated else "assumed: without an error source nothing excites the rig",
        ),
        Assumption(
            "runout of pinion and ring",
            f"{_um(pinion.runout.amplitude)} and {_um(ring.runout.amplitude)} (eccentricity)",
            free,
        ),
        Assumption(
            "initial states",
            f"seed {case.run.seed}: drawn within 0.9 of the clearance circle, 1 mm/s",
            "assumed",
        ),
        *_small_things(case),
    ]


def _small_things(case: Case) -> list[Assumption]:
    """Return damping of the ring's centre, tilt of the rig, ripple of the drive and a shaking floor, where there are any."""
    ring, ripple, found = case.rotors["ring"], getattr(case.rotors["pinion"].drive, "ripple", ()), []
    if ring.radial_damping:
        found.append(Assumption("radial damping of the ring", f"{ring.radial_damping:.3g} N s/m", FITTED))
    if ripple:
        terms = " + ".join(f"{100.0 * term.amplitude:.2g} % of order {term.order}" for term in ripple)
        found.append(Assumption("ripple of the drive's speed", terms, FITTED))
    if case.base is not None and (floor := case.base.random) is not None:
        (first, density), (last, _) = floor.density
        words = (
            f"{density:.2g} m²/s⁴/Hz from {first:g} to {last:g} Hz, {1e3 * floor.rms():.2g} mm/s² rms,"
            f" at {math.degrees(floor.direction):.0f}° to the line of centres; each run has a record of its own"
        )
        found.append(
            Assumption("acceleration of the floor", words, f"{FITTED}; in no equation of the article")
        )
    pull = math.hypot(*case.gravity)
    if pull == 0.0:
        return [*found, Assumption("gravity", "none: the plane of the rig is horizontal", "article")]
    tilt = math.degrees(math.asin(pull / STANDARD_GRAVITY))
    along, across = (1e3 * float(g) for g in case.gravity)
    words = f"{along:.2g} and {across:.2g} mm/s² along and across the line of centres: a tilt of {tilt:.2g}°"
    return [*found, Assumption("gravity", words, f"{FITTED}; the article's rig is horizontal")]
