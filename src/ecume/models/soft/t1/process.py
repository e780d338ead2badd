"""The T1 process: four spheres exchange neighbors under external forces. [rognon2009].

Spheres 0 and 1 are left and right, 2 and 3 above and below; the horizontal pair separates, and the vertical pair comes
into contact. Lengths are in radii and forces in E R^2; times are in eta R^2 / F_N, where F_N = |F_h - F_v/sqrt(3)| is
the tension on the film of the horizontal pair. Tension is positive.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import cast

import numpy as np

from ecume.errors import BadInput, Diverged
from ecume.laws.arguments import chosen, require_finite, require_number, require_positive
from ecume.laws.soft_pair import PREFACTORS
from ecume.models.soft.contacts.rotation import turned_orientation
from ecume.models.soft.setup import parameters_of, start
from ecume.models.soft.state import ACCEPTED, REJECTED, workspace
from ecume.models.soft.t1 import paper_scheme
from ecume.models.soft.t1.cluster import (
    SQRT3,
    T1,
    THRESHOLD,
    Effort,
    Instant,
    Units,
    follow_symmetric,
    goals_of,
    horizon,
    parting,
    result_of,
    seconds,
    t1_scene,
)
from ecume.models.soft.t1.cluster_steps import begin, cluster_of, has_ended, noted, take_step
from ecume.scenes.soft import SoftScene

FAINT, FAINTEST = 5e-7, 1e-12
"""Below the first kappa the deflections are separate unknowns, since positions resolve them only to 4e-16 radii. Below
the second kappa the result would not differ from that of rigid spheres.
"""
MOST_FORCE = 2.0
"""E R^2: it deflects a surface by more than a radius"""
NARROWEST, WIDEST = 1e-10, 1.0
"""The range of initial gaps, in radii."""
LONGEST_PARTING = 1e16
"""The longest closed-form time of separation (eta R^2 / F_N)."""
EQUAL = 1e-12
"""The relative distance of forces from the boundary between outcomes below which the driving force vanishes."""
TOLERANCES = 1e-11, 1e-2
"""The range of `rtol`, as in a scene."""


def t1_process(
    *,
    gap: float,
    reduced_force: float | None = None,
    forces: tuple[float, float] | None = None,
    prefactors: str = "paper",
    force_ratio: float | None = None,
    ramp: float = 0.01,
    threshold: float | Sequence[float] = THRESHOLD,
    rtol: float = 1e-8,
    rotation: bool = False,
    method: str = "implicit",
    time_step: float | None = None,
) -> T1:
    """Simulate the neighbor exchange of four spheres, and measure its duration.

    `gap` is the initial gap of the five close pairs. The forces are given either by `reduced_force` (kappa) and
    `force_ratio` (F_h/F_v, by default 0), or by `forces` (F_h, F_v), both inward; they increase linearly over `ramp`.
    The process is complete when the vertical pair is the closer one and carries the part `threshold` of F_v -
    F_h/sqrt(3) permanently; with several thresholds, the last one defines the duration. With `rotation` the spheres may
    spin.

    `method` is `implicit`, with steps as long as the tolerance `rtol` of ln(gap) permits; `paper`, the scheme of the
    paper; or `rk2` and `rk4`, the same scheme with Runge-Kutta steps. The explicit schemes have fixed steps of about
    `time_step`, by default eta/E, of which a whole number fits into the ramp. Below kappa = 5e-7 the unknowns of the
    implicit method are the deflections.
    """
    pull = _forces(reduced_force, force_ratio, forces)
    thresholds = _thresholds(threshold)
    require_positive("ramp", ramp)
    _require_between("gap", gap, (NARROWEST, WIDEST), "in radii")
    _require_between("rtol", rtol, TOLERANCES)
    _require_choices(prefactors, method, rotation)
    kappa = abs(pull[0] - pull[1] / SQRT3)
    if kappa < FAINTEST:
        raise BadInput(f"the reduced force is {kappa:.3g}; expected {FAINTEST:g} or more: spheres are rigid below")
    if (most := max(map(abs, pull))) > MOST_FORCE:
        cause = "surfaces would be deflected by more than a radius"
        raise BadInput(f"the largest force is {most:.3g} E R^2: {cause}; expected {MOST_FORCE:g} or less")
    if (time := parting(gap, kappa, prefactors)) > LONGEST_PARTING:
        cause = f"the pair would part in {time:.2g} eta R^2 / F_N, beside which no clock resolves the sliding"
        raise BadInput(f"{cause}; expected a wider gap or a smaller force, for {LONGEST_PARTING:g} or less")
    if method != "implicit":
        _require_explicit(method, rotation, kappa)
        scene = t1_scene(gap, pull, prefactors, ramp, rtol)
        return paper_scheme.follow(scene, pull, thresholds, (method, time_step))
    if time_step is not None:
        raise BadInput(f"time_step is {time_step!r}, but the implicit method chooses its steps by rtol; omit it")
    if kappa < FAINT:
        return follow_symmetric(gap, pull, thresholds, (prefactors, ramp, rtol))
    scene = replace(t1_scene(gap, pull, prefactors, ramp, rtol), rotation=rotation)
    second = seconds(horizon(gap, kappa, prefactors, ramp))
    return follow(scene, pull, thresholds, (1.0, 1.0, second))


def _forces(reduced: float | None, ratio: float | None, forces: tuple[float, float] | None) -> tuple[float, float]:
    """The forces (F_h, F_v) in E R^2."""
    if (reduced is None) == (forces is None):
        raise BadInput("expected either reduced_force or forces; got " + ("neither" if forces is None else "both"))
    if reduced is not None:
        require_positive("reduced_force", reduced)
        inward = 0.0 if ratio is None else ratio
        require_finite("force_ratio", inward)
        if abs(inward - 1.0 / SQRT3) < EQUAL:
            raise BadInput("force_ratio is 1/sqrt(3): nothing pulls at the horizontal film; expected another")
        vertical = reduced / abs(inward - 1.0 / SQRT3)
        return inward * vertical, vertical
    if ratio is not None:
        raise BadInput(f"force_ratio is {ratio!r}, but forces give both forces; expected one of the two")
    both = _items(forces)
    if both is None or len(both) != 2:
        raise BadInput(f"forces are {forces!r}; expected two numbers, F_h and F_v")
    for name, force in zip(("F_h of forces", "F_v of forces"), both, strict=True):
        require_finite(name, force)
    if abs(both[0] - both[1] / SQRT3) <= EQUAL * abs(both[1]):
        raise BadInput(f"forces are {forces!r}; expected F_h different from F_v/sqrt(3)")
    return float(both[0]), float(both[1])


def _items(value: object) -> tuple[float, ...] | None:
    """The items of a sequence or vector; None for other values."""
    listed = isinstance(value, Sequence) and not isinstance(value, str | bytes)
    vector = isinstance(value, np.ndarray) and value.ndim == 1
    return tuple(cast("Sequence[float]", value)) if listed or vector else None


def _thresholds(threshold: float | Sequence[float]) -> tuple[float, ...]:
    """The thresholds in the given order."""
    several = _items(threshold)
    found = cast("tuple[float, ...]", (threshold,)) if several is None else several
    if not found:
        raise BadInput("threshold is empty; expected a number between 0 and 1, or several")
    for one in found:
        require_number("threshold", one)
        if not 0.0 < one < 1.0:
            raise BadInput(f"the threshold is {one!r}; expected a part of the force, between 0 and 1")
    if len(set(found)) < len(found):
        raise BadInput(f"threshold is {found!r}; expected different numbers")
    return found


def _require_between(name: str, value: float, ends: tuple[float, float], unit: str = "") -> None:
    """Raise BadInput for numbers outside of a range; the upper end is included for tolerances only."""
    require_number(name, value)
    if not ends[0] <= value <= ends[1] or (unit and value == ends[1]):
        expected = f"at least {ends[0]:g} and below {ends[1]:g}, {unit}" if unit else f"{ends[0]:g} to {ends[1]:g}"
        raise BadInput(f"the {name} is {value!r}; expected {expected}")


def _require_choices(prefactors: str, method: str, rotation: bool) -> None:
    """Raise BadInput for unknown names, and for a `rotation` that is not a boolean."""
    for name, value in (("prefactors", prefactors), ("method", method)):
        if not isinstance(value, str):
            raise BadInput(f"{name} is {value!r}; expected a name")
    chosen(dict.fromkeys(("implicit", *paper_scheme.SCHEMES)), method, "method")
    chosen(PREFACTORS, prefactors, "set of prefactors")
    if not isinstance(rotation, bool):
        raise BadInput(f"rotation is {rotation!r}; expected True or False")


def _require_explicit(method: str, rotation: bool, kappa: float) -> None:
    """Raise BadInput for options that explicit steps of positions cannot simulate."""
    if rotation:
        raise BadInput(f"method={method!r} has no rotation; expected method='implicit'")
    if kappa < FAINT:
        cause = f"method={method!r} loses the deflections of a reduced force of {kappa:.3g} in rounding"
        raise BadInput(f"{cause}; expected method='implicit', or {FAINT:g} or more")


def follow(
    scene: SoftScene,
    forces: tuple[float, float],
    thresholds: Sequence[float],
    units: tuple[float, float, float] = (1.0, 1.0, 1.0),
) -> T1:
    """Integrate a cluster until it has exchanged neighbors, dissociated, or come to rest.

    `forces` are the external forces in E R^2, `units` the length, force (E R^2) and time (eta R^2 / F_N) of the scene.
    """
    horizontal, vertical = forces
    parameters = parameters_of(scene)
    state = start(scene, parameters)
    kappa = abs(horizontal - vertical / SQRT3)
    unit = Units(units[0], units[1] * kappa, units[2])
    step = workspace(parameters, state, 1.0).step
    cluster = cluster_of(parameters, state, step, unit, goals_of(forces, thresholds))
    begin(cluster)
    series, drift, ended = [noted(cluster, 1)], 0.0, False
    while not ended:
        if not take_step(cluster):
            raise Diverged(f"at t = {series[-1].time:g} no step is short enough; look at the gap and the forces")
        series.append(Instant(*map(float, noted(cluster, 1))))
        drift = max(drift, float(np.abs(step.bodies.right).max()) / unit.force)
        state.orientation[:] = turned_orientation(state.orientation, step.spins.turn / parameters.radius[:, None])
        ended = has_ended(cluster)
    turned = float(np.abs(state.orientation).max(initial=0.0))
    effort = Effort(int(state.tally[ACCEPTED]), int(state.tally[REJECTED]), drift, turned)
    return result_of(series, cluster.seen.found.tolist(), thresholds, kappa, effort)
