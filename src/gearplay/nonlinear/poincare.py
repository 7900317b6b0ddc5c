"""`poincare`, impact sections and `portrait` of a case."""

from collections.abc import Sequence

from gearplay.model.initial import usual_member
from gearplay.model.reading import Source
from gearplay.nonlinear.portrait import Portrait, portrait_of
from gearplay.nonlinear.sections import Section, contact_section, stroboscopic_section
from gearplay.results.simulate import case_of


def section(
    case: Source,
    signals: Sequence[str],
    *,
    keep: int = 1000,
    settle: int = 0,
    period: str | float = "common",
    member: int | None = None,
) -> Section:
    """Return signals of a case once per period.

    Parameters
    ----------
    case
        A `Case`, a bundled name, a path or a mapping.
    signals
        ``ring.x``, ``ring.vx`` ...: those that follow from the state.
    keep, settle
        Periods that are kept, after so many.
    period
        "common" (after which all that excites begins anew), that of the first "mesh", of its driver ("shaft"), or a time [s].
    member
        Member of the ensemble, 0 for the start as given; if not given 0, or 1, a drawn start, where 0 would be exactly centred.

    Returns
    -------
    Section
        ``times`` [s], shape [instant], and ``values`` [SI], shape [instant, signal].

    Raises
    ------
    InputError
        For a case without a period or signals it does not have.

    Examples
    --------
    >>> section("han2021", ["ring.x", "ring.vx"], keep=3, settle=2, period="mesh").values.shape
    (3, 2)

    """
    base = case_of(case)
    member = usual_member(base) if member is None else member
    return stroboscopic_section(base, signals, keep=keep, settle=settle, period=period, member=member)


def impacts(
    case: Source,
    signals: Sequence[str],
    contact: str,
    *,
    change: str = "onset",
    duration: float | None = None,
    transient: float | None = None,
    member: int | None = None,
) -> Section:
    """Return signals of a case at every onset or release of a contact, at the instants that the solver located.

    Parameters
    ----------
    case
        A `Case`, a bundled name, a path or a mapping.
    signals
        ``ring.x``, ``ring.vx`` ...: those that follow from the state.
    contact
        A sleeve's name or a flank: ``ring``, ``pinion-ring:drive``.
    change
        "onset" or "release".
    duration, transient
        Record and time before it [s]; the case's if not given.
    member
        Member of the ensemble, 0 for the start as given; if not given 0, or 1, a drawn start, where 0 would be exactly centred.

    Returns
    -------
    Section
        ``values`` [SI], shape [instant, signal], the rate of penetration [m/s] last.

    Raises
    ------
    InputError
        For a contact, change or signals that the case does not have.

    Examples
    --------
    >>> impacts("han2021", ["ring.x"], "pinion-ring:drive", duration=0.2, transient=0.0).names
    ('ring.x', 'pinion-ring:drive.rate')

    """
    base = case_of(case, duration=duration, transient=transient)
    return contact_section(
        base,
        signals,
        contact,
        change=change,
        duration=base.run.duration,
        transient=base.run.transient,
        member=usual_member(base) if member is None else member,
    )


def portrait(
    case: Source,
    *,
    settle: int = 200,
    keep: int = 500,
    show: int = 60,
    period: str | float = "mesh",
    member: int | None = None,
) -> Portrait:
    """Return all that is free to move along a settled motion, once per period, and at each onset of a contact.

    Parameters
    ----------
    case
        A `Case`, a bundled name, a path or a mapping.
    settle, keep
        Periods that pass, and periods of section and onsets.
    show
        Periods over which the path is sampled, 200 times a mesh period.
    period
        "common" (after which all that excites begins anew), that of the first "mesh", of its driver ("shaft"), or a time [s].
    member
        Member of the ensemble, 0 for the start as given; if not given 0, or 1, a drawn start, where 0 would be exactly centred.

    Returns
    -------
    Portrait
        ``ds`` has ``path.SIGNAL``, ``section.SIGNAL`` and ``onset.SIGNAL`` [SI], each over its time [s].

    Raises
    ------
    InputError
        For a case without a period or numbers that cannot be.

    Examples
    --------
    >>> portrait("han2021", settle=2, keep=3, show=1).ds.sizes["section_time"]
    3

    """
    base = case_of(case)
    member = usual_member(base) if member is None else member
    return portrait_of(base, settle=settle, keep=keep, show=show, period=period, member=member)
