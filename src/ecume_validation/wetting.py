"""Contact angles: drops on plates, and liquid that rises between plates."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from ecume.simulation import simulate
from ecume.trajectories.frame import Frame
from ecume_validation.runner import Row, case_scene, frames_of, within

AREA, VOLUME = 2e-6, 0.5e-9
"""Area (m^2) and volume (m^3) of the liquid."""
TENSION, DENSITY, WEIGHT = 0.0728, 1000.0, 200.0
"""Surface tension (N/m), density (kg/m^3) and gravity (m/s^2) for a capillary length of 0.6 mm."""
RISE = 0.02 * 0.5 / (1000.0 * 9.81) * (2.0 / 1e-3 - 2.0 / 3e-3)
"""Jurin's difference of levels in `rise.toml` (m)."""


def rows() -> list[Row]:
    """Compare drops on a plate with and without gravity, capillary rise, and a drop in 3D."""
    return [*drops_on_a_plate(), *heavy_drops(), *rise(), *drop_in_space()]


def height(frames: Sequence[Frame]) -> float:
    """The height of the center of the liquid above the plate (m), averaged over the last quarter."""
    late = frames[3 * len(frames) // 4 :]
    return float(np.mean([frame.arrays["position"][:, 1].mean() for frame in late]))


def drops_on_a_plate() -> list[Row]:
    """Compare the contact angles of drops without gravity: the angle of the circular segment whose centroid has the
    same height.
    """
    found = []
    for walls, angles in (("mirror", (30, 60, 90, 120, 150)), ("dummy", (60, 120))):
        for angle in angles:
            frames = list(frames_of("wetting", [f"liquid.contact_angle={angle} deg", f"tank.walls={walls}"]))
            measured = angle_of(height(frames), segment_height)
            found.append(within(f"drop on a plate, {walls}: angle at {angle} degrees", measured, angle, 6.0))
    return found


def angle_of(center: float, height_at: Callable[[float], float]) -> float:
    """The contact angle (degrees) for which the centroid of a drop has this height."""
    found: float = brentq(lambda angle: height_at(math.radians(angle)) - center, 20.0, 160.0)
    return found


def segment_height(angle: float) -> float:
    """The height of the centroid (m) of the segment of a circle with the area of the drop."""
    radius = math.sqrt(AREA / (angle - math.sin(angle) * math.cos(angle)))
    return 2.0 / 3.0 * math.pow(radius * math.sin(angle), 3.0) / AREA - radius * math.cos(angle)


def cap_height(angle: float) -> float:
    """The height of the centroid (m) of the segment of a ball with the volume of the drop."""
    top = 1.0 - math.cos(angle)
    radius = math.cbrt(VOLUME / (math.pi / 3.0 * top * top * (3.0 - top)))
    return radius * (0.75 * (2.0 - top) * (2.0 - top) / (3.0 - top) - math.cos(angle))


def heavy_drops() -> list[Row]:
    """Compare the contact angles of drops under gravity: the angle of the Young-Laplace profile whose centroid has the
    same height.
    """
    found = []
    for angle in (60, 120):
        changes = [f"liquid.contact_angle={angle} deg", f"gravity=[0.0, -{WEIGHT}]"]
        measured = angle_of(height(list(frames_of("wetting", changes))), young_laplace_height)
        found.append(within(f"drop with weight: angle at {angle} degrees", measured, angle, 6.0))
    return found


def young_laplace_height(angle: float) -> float:
    """The height of the centroid (m) of a heavy drop in 2D, from the curvature of its top that gives its area."""

    def shape(curvature: float) -> tuple[float, float]:
        """The area below the profile, and its moment about the plate."""

        def slope(_: float, state: np.ndarray) -> list[float]:
            _, depth, turned, _, _ = state
            along, down = math.cos(turned), math.sin(turned)
            half = state[0]
            return [
                along,
                down,
                curvature + DENSITY * WEIGHT * depth / TENSION,
                2.0 * half * down,
                2.0 * half * down * depth,
            ]

        def ends(_: float, state: np.ndarray) -> float:
            return float(state[2] - angle)

        ends.terminal = True  # type: ignore[attr-defined]
        solved = solve_ivp(slope, (0.0, 0.1), [0.0] * 5, events=ends, rtol=1e-10, atol=1e-14)
        _, depth, _, area, moment = solved.y[:, -1]
        return float(area), float(depth * area - moment)

    top: float = brentq(lambda curvature: shape(curvature)[0] - AREA, 1e-2, 1e5)
    area, moment = shape(top)
    return moment / area


def rise() -> list[Row]:
    """Compare the levels in two gaps: volumes above the lower edge of the plate, over the widths."""
    frames = list(simulate(case_scene("wetting", name="rise")))
    late = [difference(frame) for frame in frames[2 * len(frames) // 3 :]]
    return [within("rise between plates: difference of levels", float(np.mean(late)), RISE, 0.08 * RISE)]


def difference(frame: Frame) -> float:
    """The level in the narrow gap minus that in the wide one (m)."""
    x, y = frame.arrays["position"].T
    high = (y > 1.5e-3) * frame.arrays["mass"] / DENSITY
    return float(high[x < 1e-3].sum() / 1e-3 - high[x > 1.5e-3].sum() / 3e-3)


def drop_in_space() -> list[Row]:
    """Compare a spreading drop in 3D that starts as half a cube."""
    changes = [
        "tank.low=[-1.5e-3, 0.0, -1.5e-3]", "tank.high=[1.5e-3, 1.5e-3, 1.5e-3]", "gravity=[0.0, 0.0, 0.0]",
        "tank.front={kind='open'}", "tank.back={kind='open'}", "duration=40 ms", "frame_every=4 ms",
        "liquid.contact_angle=60 deg", "liquid.maximum_speed=0.8 m/s",
        "fluid=[{low=[-0.5e-3, 0.0, -0.5e-3], high=[0.5e-3, 0.5e-3, 0.5e-3]}]",
    ]  # fmt: skip
    measured = angle_of(height(list(frames_of("wetting", changes))), cap_height)
    return [within("drop on a plate in 3D: angle at 60 degrees", measured, 60.0, 8.0)]
