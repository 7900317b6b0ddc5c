"""Stiffness and errors of the teeth over the mesh phase psi: sums of harmonics, square wave, periodic spline; their slopes."""

import math
from typing import Any

from gearplay.kernels.arrays import Floats
from gearplay.kernels.compiled import compiled, compiled_inline
from gearplay.kernels.layout import System

TWO_PI = 2.0 * math.pi
STIFFNESS_FOURIER, STIFFNESS_SQUARE, STIFFNESS_SPLINE = 0, 1, 2


@compiled_inline
def harmonics(
    terms: Floats, start: int, count: int, cos_psi: float, sin_psi: float
) -> tuple[float, float, float]:
    """Return sum a cos(k psi + phase), sum a sin(k psi + phase) and the latter's slope sum k a cos(k psi + phase).

    The multiples of psi come from its sine and cosine by rotation, so one pair serves every term of a mesh.
    """
    cosines, sines, slopes = 0.0, 0.0, 0.0
    c, s, order = 1.0, 0.0, 0.0
    for i in range(start, start + count):
        while order < terms[i, 0]:
            c, s = c * cos_psi - s * sin_psi, s * cos_psi + c * sin_psi
            order += 1.0
        cosine, sine = terms[i, 1] * c - terms[i, 2] * s, terms[i, 1] * s + terms[i, 2] * c
        cosines += cosine
        sines += sine
        slopes += order * cosine
    return cosines, sines, slopes


@compiled_inline
def harmonic_curvatures(
    terms: Floats, start: int, count: int, cos_psi: float, sin_psi: float
) -> tuple[float, float]:
    """Return the slope of sum a cos(k psi + phase) and the second derivative of sum a sin(k psi + phase) by psi."""
    slope, curvature = 0.0, 0.0
    c, s, order = 1.0, 0.0, 0.0
    for i in range(start, start + count):
        while order < terms[i, 0]:
            c, s = c * cos_psi - s * sin_psi, s * cos_psi + c * sin_psi
            order += 1.0
        sine = terms[i, 1] * s + terms[i, 2] * c
        slope -= order * sine
        curvature -= order * order * sine
    return slope, curvature


@compiled_inline
def spline_piece(mesh: Any, system: System, psi: float) -> tuple[int, float]:
    """Return the row of the spline that holds the mesh phase psi [rad], and how far psi lies behind its start [rad]."""
    turn = (psi + mesh.phase) / TWO_PI
    angle = TWO_PI * (turn - math.floor(turn))
    row = mesh.stiffness_start + mesh.stiffness_count - 1
    while row > mesh.stiffness_start and system.spline[row, 0] > angle:
        row -= 1
    x = angle - system.spline[row, 0]
    if x < 0.0:  # before the first knot: the last piece, wrapped round
        row = mesh.stiffness_start + mesh.stiffness_count - 1
        x = angle + TWO_PI - system.spline[row, 0]
    return row, x


@compiled_inline
def mesh_stiffness(
    mesh: Any, system: System, psi: float, cos_psi: float, sin_psi: float, segment: int
) -> float:
    """Return K(psi) [N/m] at mesh phase psi [rad], eq. (16) and its generalisations.

    ``segment`` counts the half-waves passed by a square wave, so that a stage of the stepper that overshoots
    a jump still sees the branch it started on.
    """
    if mesh.stiffness_kind == STIFFNESS_FOURIER:
        variation, _, _ = harmonics(
            system.terms, mesh.stiffness_start, mesh.stiffness_count, cos_psi, sin_psi
        )
        return mesh.k_m + variation
    if mesh.stiffness_kind == STIFFNESS_SQUARE:
        return mesh.k_m if segment % 2 == 0 else mesh.k_single
    row, x = spline_piece(mesh, system, psi)
    p = system.spline[row]
    return p[1] + x * (p[2] + x * (p[3] + x * p[4]))


@compiled
def stiffness_slope(mesh: Any, system: System, psi: float, cos_psi: float, sin_psi: float) -> float:
    """Return dK/dpsi [N/m] of `mesh_stiffness` between the edges of a square wave."""
    if mesh.stiffness_kind == STIFFNESS_FOURIER:
        slope, _ = harmonic_curvatures(
            system.terms, mesh.stiffness_start, mesh.stiffness_count, cos_psi, sin_psi
        )
        return slope
    if mesh.stiffness_kind != STIFFNESS_SPLINE:
        return 0.0
    row, x = spline_piece(mesh, system, psi)
    p = system.spline[row]
    return p[2] + x * (2.0 * p[3] + 3.0 * x * p[4])


@compiled_inline
def square_edge(mesh: Any, segment: int) -> float:
    """Return the mesh phase psi [rad] at which segment ``segment`` of a square wave begins."""
    turns = segment // 2
    part = mesh.duty if segment % 2 == 1 else 0.0
    return TWO_PI * (turns + part) - mesh.phase


@compiled
def square_segment(mesh: Any, psi: float) -> int:
    """Return the segment of a square wave that holds the mesh phase psi [rad]."""
    turn = (psi + mesh.phase) / TWO_PI
    whole = math.floor(turn)
    return int(2 * whole + (1 if turn - whole >= mesh.duty else 0))
