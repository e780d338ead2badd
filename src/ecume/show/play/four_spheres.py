"""The T1 process of four spheres in a page that simulates: the numbers that the page needs."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ecume.models.soft.setup import parameters_of, start
from ecume.models.soft.state import workspace
from ecume.models.soft.t1.cluster import (
    OUTCOMES,
    SQRT3,
    THRESHOLD,
    Units,
    goals_of,
    horizon,
    parting,
    seconds,
    t1_scene,
)
from ecume.models.soft.t1.cluster_steps import Cluster, cluster_of
from ecume.scenes.soft import SoftScene
from ecume.scenes.writing import to_toml
from ecume.show.play.memory import slots
from ecume.show.view.page import color_map

GAPS = (1e-3, 1e-2, 1e-1)
"""In radii."""
FORCES = (1e-5, 1e-4, 1e-3, 1e-2, 1e-1)
"""Reduced forces F_N/(E R^2)."""
RATIOS = (-0.3, 0.0, 0.3, 0.7)
"""F_h/F_v: above 1/sqrt(3) the cluster is blocked."""
SAME = 1e-6
"""The relative difference below which numbers of a scene are those above; also that of the distances of a cluster."""
TOLERANCE, RAMP, PREFACTORS = 1e-8, 0.01, "paper"
"""As the defaults of `t1_process`."""
SPEEDS = (0.0, 0.25, 1.0, 4.0)
WHILE = 12.0
"""s in which a process is played at speed 1, about."""


FRAMES = 400
"""of a scene that is saved."""


class Pulled(NamedTuple):
    """A cluster with its forces at the start: see `t1_process`."""

    gap: float
    reduced_force: float
    force_ratio: float

    @property
    def forces(self) -> tuple[float, float]:
        """The forces F_h and F_v in E R^2."""
        vertical = self.reduced_force / abs(self.force_ratio - 1.0 / SQRT3)
        return self.force_ratio * vertical, vertical

    @property
    def scene(self) -> SoftScene:
        """The scene in units of radii and E R^2."""
        return t1_scene(self.gap, self.forces, PREFACTORS, RAMP, TOLERANCE)


def cluster_at(pulled: Pulled) -> Cluster:
    """The cluster at the start of `t1_process`."""
    scene = pulled.scene
    parameters = parameters_of(scene)
    state = start(scene, parameters)
    second = seconds(horizon(pulled.gap, pulled.reduced_force, PREFACTORS, RAMP))
    units = Units(1.0, pulled.reduced_force, second)
    step = workspace(parameters, state, 1.0).step
    return cluster_of(parameters, state, step, units, goals_of(pulled.forces, (THRESHOLD,)))


USUAL = Pulled(1e-2, 1e-3, 0.0)


def cluster_arguments(pulled: Pulled = USUAL) -> dict[str, Any]:
    """The arguments of the compiled step of a cluster."""
    return {"cluster": cluster_at(pulled)}


def pulled_in(scene: SoftScene) -> Pulled | None:
    """The cluster of a scene that is a T1 process in other units, or None."""
    if scene.liquid.viscosity is None or any(len(spec.positions) != spec.number for spec in scene.particles):
        return None
    parameters = parameters_of(scene)
    places = np.array([place for spec in scene.particles for place in spec.positions])
    radius, modulus, force = parameters.radius, parameters.modulus, parameters.force
    if places.shape != (4, 2) or np.ptp(radius) > SAME * radius[0] or np.ptp(modulus) > SAME * modulus[0]:
        return None
    gap = float(np.hypot(*(places[1] - places[0])) / radius[0] - 2.0)
    pulls = force / (modulus[0] * radius[0] ** 2)
    vertical, horizontal = -float(pulls[2, 1]), float(pulls[0, 0])
    if vertical == 0.0 or gap <= 0.0:
        return None
    ratio = horizontal / vertical
    if abs(SQRT3 * ratio - 1.0) < SAME:  # the net force is zero
        return None
    found = Pulled(gap, abs(horizontal - vertical / SQRT3), ratio)
    unit = scene.liquid.viscosity / (modulus[0] * found.reduced_force)
    ramp = float(parameters.protocol.times[-1]) / unit
    return found if vertical > 0.0 and _is_cluster(scene, found, (places, pulls, ramp)) else None


def _is_cluster(scene: SoftScene, found: Pulled, seen: tuple[Any, Any, float]) -> bool:
    """Whether a scene differs from a T1 process only by its units."""
    places, pulls, ramp = seen
    ours, radius = found.scene, parameters_of(scene).radius[0]
    bare = replace(ours, **{name: getattr(scene, name) for name in UNLIKE})
    where = np.array([place for spec in ours.particles for place in spec.positions])
    forces = np.array([spec.force for spec in ours.particles])
    return (
        bare == scene
        and bool(np.abs(places / radius - where).max() < SAME)
        and bool(np.abs(pulls - forces).max() < SAME * np.abs(forces).max())
        and math.isclose(ramp, RAMP, rel_tol=1e-2)
    )


UNLIKE = ("title", "duration", "frame_every", "liquid", "particles", "protocol", "integration", "seed", "output",
    "on_violation",
)  # fmt: skip
"""Fields of a scene whose units, or whose meaning for a page, differ."""


def joined(usual: tuple[float, ...], given: float) -> list[float]:
    """Sorted numbers with another one, unless it is already among them."""
    if any(math.isclose(given, one, rel_tol=SAME, abs_tol=1e-9) for one in usual):
        return list(usual)
    return sorted([*usual, given])


def offered_clusters(pulled: Pulled) -> dict[str, Any]:
    """The data for the page of a cluster: the choices, and the arguments for each."""
    gaps, forces = joined(GAPS, pulled.gap), joined(FORCES, pulled.reduced_force)
    ratios = joined(RATIOS, pulled.force_ratio)
    base = finite(slots(cluster_arguments(pulled)))
    cases = [_case(Pulled(gap, force, ratio), base) for gap in gaps for force in forces for ratio in ratios]
    begins = [_nearest(gaps, pulled.gap), _nearest(forces, pulled.reduced_force), _nearest(ratios, pulled.force_ratio)]
    return {"choices": [gaps, forces, ratios], "begins": begins, "slots": base, "cases": cases, "outcomes": OUTCOMES}


def _nearest(values: list[float], value: float) -> int:
    return int(np.argmin(np.abs(np.array(values) - value)))


def _case(pulled: Pulled, base: list[list[Any]]) -> dict[str, Any]:
    """The differences of a case from the first cluster, its playing speed, and its scene."""
    own = finite(slots(cluster_arguments(pulled)))
    other = {one[0]: one[3] for one, ours in zip(own, base, strict=True) if one[3] != ours[3]}
    scene = replace(pulled.scene, frame_every=pulled.scene.duration / FRAMES)
    return {"slots": other, "rate": _rate(pulled), "pull": pulled.forces, "scene": to_toml(scene)}


def _rate(pulled: Pulled) -> float:
    """The time of a process (eta R^2 / F_N) per second of the clock. The motion of a blocked cluster ends long before
    it counts as blocked.
    """
    given = pulled.gap, pulled.reduced_force, PREFACTORS
    blocked = pulled.force_ratio > 1.0 / SQRT3
    return 1.4 / WHILE * (0.25 * horizon(*given, RAMP) if blocked else parting(*given))


def finite(found: list[list[Any]]) -> list[list[Any]]:
    """The table without infinite numbers, which JSON does not have."""
    return [[name, kind, _sizes(shape), _finite(value)] for name, kind, shape, value in found]


def _sizes(shape: list[int] | None) -> list[list[int]] | None:
    return None if shape is None else [[0, size] for size in shape]


def _finite(value: Any) -> Any:
    if isinstance(value, list):
        return [_finite(one) for one in value]
    if isinstance(value, float) and not math.isfinite(value):
        return "NaN" if math.isnan(value) else "Infinity" if value > 0.0 else "-Infinity"
    return value


def page_header(scene: SoftScene) -> dict[str, Any]:
    """The data that the page of a cluster reads at its start."""
    return {
        "title": scene.title or "A T1 process",
        "speeds": SPEEDS,
        "colors": [color_map("viridis"), color_map("viridis", dark=True)],
    }
