"""The floating model, as the driver sees it."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import psutil

from ecume._jit import compiled_once
from ecume.errors import BadInput, Fault, SceneError
from ecume.laws import capillarity, flotation
from ecume.models.floating.building import afloat, good_step, parameters_of
from ecume.models.floating.forces import forces_with, pull_rows_with
from ecume.models.floating.observing import observe
from ecume.models.floating.pace import LARGEST_OVER_CHOSEN, LOOSEST_OVER_CHOSEN
from ecume.models.floating.parameters import PairParameters, Parameters
from ecume.models.floating.starting import start
from ecume.models.floating.state import State, Workspace, list_reach, make_workspace
from ecume.models.floating.stepping import advance, advance_with, renew_lists
from ecume.models.liquids import liquid_of
from ecume.models.model import Model
from ecume.scenes.floating import FloatingScene, FloatRow, FloatSpec, species_of

ROOMIER = 1.6
BYTES_PER_FLOAT = 1200
BYTES_PER_NEIGHBOR = 4
LEAST_DISTANCE = 1e-300


def workspace(parameters: Parameters, state: State, room: float) -> Workspace:
    """Scratch with neighbor lists that hold at the state's reference positions."""
    while True:
        made = make_workspace(parameters, state, room)
        if renew_lists(parameters, state, made):
            return made
        room *= ROOMIER


def checked_parameters(scene: FloatingScene) -> Parameters:
    """The parameters of a scene that fits into the machine."""
    count = len(scene.rows) + sum(species.count for species in scene.floats)
    # Tested before anything is laid out: a hundred million floats are typed as quickly as a hundred.
    _require_memory(count, BYTES_PER_FLOAT * count)
    parameters = parameters_of(scene)
    _require_memory(count, memory_estimate(parameters))
    return parameters


def memory_estimate(parameters: Parameters) -> float:
    """Bytes of a run, when the floats are packed to rafts."""
    count = len(parameters.floats.radius)
    packed = 0.92 * (list_reach(parameters) / float(parameters.floats.radius.min())) ** 2
    return count * (BYTES_PER_FLOAT + BYTES_PER_NEIGHBOR * ROOMIER * min(packed, count))


def _require_memory(count: int, wanted: float) -> None:
    there = psutil.virtual_memory().total
    if wanted > there:
        raise SceneError(
            [
                Fault(
                    "floats",
                    f"{count} floats need about {wanted / 1e9:.3g} GB, this machine has {there / 1e9:.3g} GB; "
                    "use fewer floats, or a larger interaction.accuracy, which shortens the cutoff",
                )
            ]
        )


def diagnosis(parameters: Parameters, state: State) -> str:
    """Who left the range where it means anything, when, and what to do."""
    speed = np.hypot(state.velocity[:, 0], state.velocity[:, 1])
    broken = ~np.isfinite(speed) | ~np.isfinite(state.position).all(axis=1)
    worst = int(np.flatnonzero(broken)[0]) if broken.any() else int(np.argmax(speed))
    time = int(state.step[0]) * parameters.time_step
    what = "has no finite position any more" if broken.any() else f"goes {speed[worst]:.3g} m/s"
    x, y = state.position[worst]
    return (
        f"at t = {time:.6g} s float {worst} {what} (at {x:.4g} m, {y:.4g} m): too far for one time step of "
        f"{parameters.time_step:.3g} s. Set motion.time_step = {0.25 * parameters.time_step:.2g}, "
        "or look for overlapping floats"
    )


def extended(extra_laws: Sequence[Callable[..., float]]) -> Model:
    """The floating model with a user's own pair laws: functions (distance, parameters) -> force (N, positive repels).

    `parameters` is a `PairParameters`. They are compiled like our own, once a process, and act up to the scene's
    cutoff.
    """
    for law in extra_laws:
        _require_force(law)
    return dataclasses.replace(FLOATING, advance=_advance_with_extra(tuple(extra_laws)))


def _require_force(law: Callable[..., float]) -> None:
    """Try a user's law on two likely spheres: what is wrong with it is told before the march is compiled around it."""
    likely = PairParameters(1e-3, 1e-3, 1e-4, 1e-4, 2.7e-3, 0.07)
    name = getattr(law, "__name__", repr(law))
    try:
        force: object = compiled_once(law)(3e-3, likely)
    except Exception as error:  # a user's function may raise anything, and so may its compilation
        said = [line for line in str(error).splitlines() if line.strip() and not line.startswith("Failed in nopython")]
        why = said[0].strip() if said else type(error).__name__
        raise BadInput(
            f"extra_laws: {name}: cannot be used: {why}; wanted a plain function (distance, parameters) -> force, of "
            "numbers and the functions of math"
        ) from error
    if isinstance(force, bool) or not isinstance(force, (int, float)):
        raise BadInput(f"extra_laws: {name}: came {force!r}; wanted a force in N")


def _advance_with_extra(laws: tuple[Callable[..., float], ...]) -> Callable[..., int]:
    """The march with the laws' sum compiled in. A function a law: a tuple of functions is no value for compiled
    code.
    """
    extra = _no_law
    for law in laws:
        extra = _sum_of(compiled_once(law), extra)

    @compiled_once
    def extra_pull(square: float, own: PairParameters) -> float:
        distance = max(math.sqrt(square), LEAST_DISTANCE)
        return -extra(distance, own) / distance

    @compiled_once
    def pull(rows: Any, floats: Any, pair: Any, force: Any) -> None:
        pull_rows_with(extra_pull, 0, force.shape[1], rows, floats, pair, force)

    @compiled_once
    def forces(parameters: Any, position: Any, lists: Any, scratch: Any) -> None:
        forces_with(pull, parameters, position, lists, scratch)

    @compiled_once
    def march(parameters: Any, state: Any, scratch: Any, steps: int) -> int:
        return advance_with(forces, parameters, state, scratch, steps)

    return march


@compiled_once
def _no_law(distance: float, own: PairParameters) -> float:
    return 0.0


def _sum_of(one: Callable[..., float], other: Callable[..., float]) -> Callable[..., float]:
    @compiled_once
    def both(distance: float, own: PairParameters) -> float:
        return one(distance, own) + other(distance, own)

    return both


def summary(scene: FloatingScene) -> list[tuple[str, str, str]]:
    """Derived numbers: name, value with unit, remark. Raises SceneError for whatever would keep a run from starting."""
    parameters = checked_parameters(scene)
    start(scene, parameters)
    liquid = liquid_of(scene)
    length = liquid.capillary_length
    kinds: dict[str, FloatSpec | FloatRow] = {given.name: given for given in scene.floats}
    kinds |= {row.species_name: row for row in reversed(scene.rows)}
    rows = [("capillary length", f"{length * 1e3:.4g} mm", "how far a meniscus reaches")]
    for name, _ in species_of(scene):
        rows += _summary_of(afloat(kinds[name], scene), name, liquid)
    frames = round(scene.duration / scene.frame_every)
    steps, count = frames * parameters.steps_per_frame, len(parameters.floats.radius)
    cutoff = parameters.cutoff / length
    left = capillarity.neglected_fraction(cutoff)
    return [
        *rows,
        (
            "cutoff",
            f"{parameters.cutoff * 1e3:.4g} mm",
            f"{cutoff:.3g} capillary lengths; {left:.1e} of a raft's pull is left out",
        ),
        ("floats", str(count), f"{len(kinds)} species"),
        (
            "time step",
            f"{parameters.time_step * 1e3:.4g} ms",
            _step_remark(parameters.time_step, good_step(parameters, scene)),
        ),
        ("steps", str(steps), f"{frames} frames of {parameters.steps_per_frame} steps"),
        ("memory", f"{memory_estimate(parameters) / 1e6:.3g} MB", "when packed to rafts"),
        ("time on this machine", _duration(seconds_per_step(count) * steps), "roughly, after compilation"),
    ]


def _step_remark(time_step: float, good: float) -> str:
    """What a longer step than this one would be; `good` is the longest good one."""
    coarse, refused = 1e3 * LOOSEST_OVER_CHOSEN * good, 1e3 * LARGEST_OVER_CHOSEN * good
    if time_step > LOOSEST_OVER_CHOSEN * good:
        return f"coarse; {1e3 * good:.3g} ms is good, refused above {refused:.3g} ms"
    return f"good; coarse above {coarse:.3g} ms, refused above {refused:.3g} ms"


def _summary_of(kind: Any, name: str, liquid: flotation.Liquid) -> list[tuple[str, str, str]]:
    sphere, balance = kind.sphere, kind.equilibrium
    bond = flotation.bond_number(sphere, liquid)
    weight = flotation.dimensionless_weight(sphere, liquid)
    limit = flotation.sinking_density_ratio(bond_number=bond, contact_angle=sphere.contact_angle)
    slope = math.degrees(balance.slope_angle)
    return [
        (f"{name}: Bond number", f"{bond:.4g}", "(R / capillary length)^2"),
        (f"{name}: density ratio", f"{flotation.density_ratio(sphere, liquid):.4g}", f"sinks above {limit:.4g}"),
        (
            f"{name}: dimensionless weight",
            f"{weight:.4g}",
            "presses the surface down" if weight > 0 else "lifts the surface",
        ),
        (f"{name}: slope at the contact line", f"{slope:.3g} deg", _slope_remark(balance.slope_angle)),
        (
            f"{name}: capillary charge",
            f"{kind.charge * 1e6:.4g} um",
            "heavy: attracts the heavy" if kind.charge > 0 else "light: attracts the light",
        ),
    ]


def _slope_remark(slope: float) -> str:
    return "steep: two of them close together pull harder than the sum says" if abs(slope) > 0.3 else "gentle"


def seconds_per_step(count: int) -> float:
    """A rough figure, of a settled raft on one core."""
    return 2e-5 + 1.5e-6 * count


def _duration(seconds: float) -> str:
    return (
        f"{seconds:.2g} s"
        if seconds < 100
        else f"{seconds / 60:.2g} min"
        if seconds < 6000
        else f"{seconds / 3600:.2g} h"
    )


FLOATING = Model(
    name="floating",
    state=State,
    parameters=checked_parameters,
    start=start,
    workspace=workspace,
    advance=advance,
    observe=observe,
    diagnosis=diagnosis,
    extended=extended,
    summary=summary,
)
