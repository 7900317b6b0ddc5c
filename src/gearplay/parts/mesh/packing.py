"""Packing of meshes: geometry, stiffness, errors and flanks."""

import math
from typing import TYPE_CHECKING, Any

from gearplay.parts.assembly import Contact, blank
from gearplay.parts.mesh import flank, tooth_stiffness
from gearplay.parts.mesh import geometry as mesh_geometry
from gearplay.parts.mesh import law as mesh_element
from gearplay.parts.mesh.involute import involute, involute_from_distance, involute_series
from gearplay.parts.mesh.mesh_stiffness import PackedStiffness, pack_stiffness
from gearplay.parts.mesh.pairs import observed
from gearplay.parts.mesh.pairs.packing import more_columns, pack_pairs
from gearplay.parts.mesh.runout import toothing_runout
from gearplay.parts.mesh.tooth_deflections import damping_depths
from gearplay.parts.mesh.tooth_places import tooth_places
from gearplay.parts.mesh.train import geometry
from gearplay.parts.protocol import Packing, slot_of
from gearplay.parts.rotor.schema import place_words
from gearplay.schema.records import harmonic_rows
from gearplay.vocabulary.errors import InputError

if TYPE_CHECKING:
    from gearplay.parts.mesh.schema import Damping
    from gearplay.parts.mesh.train.train import Train

PAIR_ORDER = 4.0
"""Order per mesh period that a step resolves where pairs of teeth have contacts of their own."""


def damping_maximum(case: "Train", j: int, stiffness: PackedStiffness) -> float:
    """Return C_m [N s/m] of mesh j; from a ratio zeta: 2 zeta sqrt(k_m m_eq), 1/m_eq = r_b1^2/J_1 + r_b2^2/J_2.

    A prescribed rotation counts as an infinite inertia; where both are prescribed their own inertias count. 0 if an inertia
    is 0.
    """
    mesh = case.meshes[j]
    if mesh.damping.ratio is None:
        return mesh.damping.maximum or 0.0
    rotors = [case.rotors[name] for name in mesh.rotors]
    mobilities = [
        r * r / rotor.inertia if rotor.inertia else math.inf
        for r, rotor in zip(geometry.base_radii(case, j), rotors, strict=True)
    ]
    free = [not rotor.is_prescribed for rotor in rotors]
    mobility = sum(m for m, moves in zip(mobilities, free, strict=True) if moves or not any(free))
    return 2.0 * mesh.damping.ratio * math.sqrt(stiffness.average / mobility)


def _damping_law(damping: "Damping") -> int:
    if damping.law == "constant":
        return flank.RAMP_CONSTANT
    return flank.RAMP_AS_PRINTED if damping.ramp == "literal" else flank.RAMP_SMOOTH


def _mesh_kind(case: "Train") -> int:
    coupled = case.backlash_model == "coupled"
    if case.formulation == "geometric":
        return mesh_geometry.MESH_COUPLED if coupled else mesh_geometry.MESH_UNCOUPLED
    return mesh_geometry.MESH_PRINTED_COUPLED if coupled else mesh_geometry.MESH_PRINTED_UNCOUPLED


def _pack_mesh(packing: Packing, j: int, m: Any) -> None:
    case: Train = packing.train
    mesh, centres, moving = case.meshes[j], packing.centres, packing.moving
    a, b, r_a, r_b = geometry.signed_radii(case, j)
    frame = geometry.mesh_frame(case, j)
    m.kind = _mesh_kind(case)
    pair = geometry.pair_of(case, j)
    cosine = math.cos(pair.first.transverse_angle)
    m.c0 = abs(r_a + r_b) * cosine
    foot, tip = geometry.rotor_of(case, a), geometry.rotor_of(case, b)
    dx, dy = centres[tip][0] - centres[foot][0], centres[tip][1] - centres[foot][1]
    m.A0 = math.hypot(dx, dy)
    m.s = -1.0 if r_a > 0.0 else 1.0
    # Between the distance where tips leave each other and that where they strike roots, which is not modelled.
    working = pair.distance
    m.A_min, m.A_max = pair.range_of_distances
    m.A_min = max(m.A_min, m.c0)
    if not m.A_min < m.A0 < m.A_max:
        way = (dx / m.A0, dy / m.A0) if m.A0 > 0.0 else (1.0, 0.0)
        place = place_words(*(c + working * each for c, each in zip(centres[foot], way, strict=True)))
        raise InputError.of(
            f"rotors.{tip}.position",
            f"{1e3 * m.A0:.6g} mm from {foot}",
            f"the centres of mesh {j} must be between {1e3 * m.A_min:.6g} mm and {1e3 * m.A_max:.6g} mm apart",
            f"Place them {1e3 * working:.6g} mm apart, {tip} at {place}, or leave the position out.",
        )
    m.u0_x, m.u0_y = dx / m.A0, dy / m.A0
    m.cos_alpha0 = m.c0 / m.A0
    m.sin_alpha0 = math.sqrt(1.0 - m.cos_alpha0**2)
    m.inv_alpha0 = involute(pair.working_angle)
    m.A_nominal_squared = working * working
    m.inv_A_nominal_squared = 1.0 / m.A_nominal_squared
    at_working = abs(m.A0 - working) < 1e-12 * working
    m.opening0 = 0.0 if at_working else m.s * m.c0 * (involute_from_distance(m.A0, m.c0) - m.inv_alpha0)
    radius = (
        1.0
        if m.kind in (mesh_geometry.MESH_PRINTED_COUPLED, mesh_geometry.MESH_PRINTED_UNCOUPLED)
        else cosine
    )
    m.rho_a, m.rho_b = r_a * radius, r_b * radius
    m.a, m.b, m.driver = packing.place(foot), packing.place(tip), packing.place(mesh.rotors[0])
    for side, name in (("a", a), ("b", b)):
        amplitude, phase = toothing_runout(case, name)
        setattr(m, f"runout_{side}", amplitude)
        setattr(m, f"runout_phase_{side}", phase)
    m.frame = packing.place(frame)
    turning = moving[m.driver] - (moving[m.frame] if frame is not None else 0.0)
    m.sigma = -1.0 if turning < 0.0 else 1.0
    if mesh.driver == geometry.ring_of(case, mesh):
        m.sigma = -m.sigma
    m.backlash = geometry.working_backlash(case, j)
    m.z_driver = float(geometry.teeth_of(case, mesh.driver))
    m.friction, m.friction_speed = mesh.friction_coefficient, mesh.friction_speed
    m.pitch_phase = mesh.friction_phase
    # The contact goes along the drive flanks' line of action by a base pitch a tooth, forwards on a, backwards on b.
    forwards = math.copysign(1.0, m.rho_a) if m.driver == m.a else -math.copysign(1.0, m.rho_b)
    m.way = 0.5 * m.sigma * forwards * pair.first.transverse_module * cosine


def pack_meshes(packing: Packing) -> None:
    """Add every mesh to a mechanism."""
    case: Train = packing.train
    assembly, spline = packing.assembly, packing.spline
    depths = damping_depths(packing.turning)
    records = [blank(mesh_element.RECORD) for _ in case.meshes]
    for j, m in enumerate(records):
        _pack_mesh(packing, j, m)
    places = tooth_places(case, packing.centres, [m.sigma for m in records])
    for j, (mesh, m) in enumerate(zip(case.meshes, records, strict=True)):
        m.psi_0, m.pair_phase = places.phases[j], places.teeth[j] - places.phases[j]
        k = pack_stiffness(case, j)
        m.stiffness_kind, m.k_m, m.k_single, m.duty, m.phase = k.kind, k.mean, k.single, k.duty, k.phase
        series, m.u_series = involute_series(geometry.pair_of(case, j).working_angle)
        packing.involutes.append(series)
        if m.backlash > 0.0:
            packing.half_backlashes[f"{mesh.label}.x"] = f"{mesh.label}.drive_penetration", 0.5 * m.backlash
        pack_pairs(packing, j, m, places.numbers[j])
        single = m.pairs == 0 or m.envelope
        if single and k.kind == tooth_stiffness.STIFFNESS_SPLINE:
            m.stiffness_start, m.stiffness_count = len(spline), len(k.rows)
            spline.extend(k.rows.tolist())
        elif single:
            m.stiffness_start, m.stiffness_count = packing.add_terms(harmonic_rows(k.rows))
        errors = [(float(e.order), e.amplitude, e.phase) for e in mesh.transmission_error]
        m.error_start, m.error_count = packing.add_terms(harmonic_rows(errors))
        m.error_slope = sum(e.order * abs(e.amplitude) for e in mesh.transmission_error)
        m.error_curvature = sum(e.order**2 * abs(e.amplitude) for e in mesh.transmission_error)
        orders = [float(e.order) for e in mesh.transmission_error]
        m.highest_order = max([1.0, k.highest_order, *orders] if single else [PAIR_ORDER, *orders])
        if m.envelope:
            m.highest_order = max(m.highest_order, PAIR_ORDER)
        m.C_m, m.depth = damping_maximum(case, j, k), depths[j]
        m.inv_depth = 1.0 / m.depth
        if mesh.damping.ratio is not None and not single:  # of all pairs in contact
            m.C_m /= max(1.0, geometry.pair_of(case, j).contact_ratio)
        m.ramp = _damping_law(mesh.damping)
        # The formulation as_published has one force, (19): the drive branch goes first.
        flanks = [
            Contact("drive"),
            Contact("back", yields_to=0 if case.formulation == "as_published" else None),
        ]
        slots = 0 if single else m.pairs
        flanks += [Contact(slot_of(side, slot)) for side in ("drive", "back") for slot in range(slots)]
        modes, slopes = more_columns(m)
        edges = int(k.kind == tooth_stiffness.STIFFNESS_SQUARE)
        slides = int(mesh.friction_coefficient > 0.0)
        mobility = sum(
            r * r * packing.records[i].inv_inertia + packing.records[i].inv_mass
            for r, i in ((m.rho_a, m.a), (m.rho_b, m.b))
        )
        rate = math.sqrt(k.highest * mobility)
        assembly.add(
            mesh_element,
            mesh.label,
            m,
            [m.a, m.b, m.frame],
            flanks,
            switches=edges + (slides if m.pairs == 0 else 0),
            of_contacts=m.envelope + slides,
            modes=modes,
            slopes=slopes,
            rate=rate,
            hides=bool(m.C_m > 0.0) and case.formulation == "geometric",
            deferred=m.pairs > 0,
        )


def add_pair_signals(packing: Packing) -> None:
    """Add the elements that show the slots of all meshes with pairs of teeth, named as their contacts."""
    assembly, kind = packing.assembly, mesh_element.KIND
    for number, label in enumerate(assembly.labels.get(kind, [])):
        m = assembly.parts[kind][number]
        for k, side in enumerate(("drive", "back")):
            for slot in range(0 if m.envelope else m.pairs):
                record = blank(observed.RECORD)
                record.mesh, record.flank, record.slot = number, k, slot
                assembly.add(observed, f"{label}:{slot_of(side, slot)}", record, [m.a, m.b, m.frame])
