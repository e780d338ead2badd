"""Random small tanks in 2D, closed and open, still or collapsing; by hand with many seeds:
`python -m tests.models.sph.random_closed_tanks 200`.
"""

import math
import sys
from typing import Any

import numpy as np

import ecume
from ecume.errors import Diverged
from ecume.scenes.load import from_plain
from tests.models.sph.scenes import OPEN


def collapsing(seed: int, pressure: str) -> Any:
    """Closed: columns of liquid, one of them up to the lid, and an obstacle in most."""
    rng = np.random.default_rng([1, seed])
    width, height = 1.0, float(rng.uniform(0.4, 1.2))
    spacing = min(width, height) / rng.integers(8, 15)
    ends = np.concatenate([[0.0], np.sort(rng.uniform(0.2, 0.8, 2)), [width]])
    tops = rng.permutation([height, *rng.uniform(0.15, 1.0, 2) * height])
    fluid = [
        {"low": [a, 0.0], "high": [b, top]}
        for a, b, top in zip(ends[:-1], ends[1:], tops, strict=True)
        if b - a > 2 * spacing
    ]
    solids = [{"center": [0.5, 0.4 * height], "radius": 0.12 * height}] if rng.uniform() < 0.7 else []
    tank = {"high": [width, height], "walls": str(rng.choice(["mirror", "dummy"]))}
    return plain_of(spacing, tank, fluid, pressure, height, obstacles=solids)


def still(seed: int, pressure: str) -> Any:
    """A pool, or a full tank, around a disc, box or wedge, free or on the floor, with displaced particles."""
    rng = np.random.default_rng([2, seed])
    width, depth = 1.0, float(rng.uniform(0.5, 1.0))
    spacing = depth / 16.0
    room = float(rng.choice([0.0, 0.5]))
    radius = float(rng.uniform(0.12, 0.18)) * depth
    height = radius if rng.uniform() < 0.5 else 0.5 * depth
    solid: dict[str, Any] = {"center": [0.5, height], "radius": radius}
    if rng.uniform() < 0.4:
        solid = {"vertices": [[0.0, 0.0], [0.4, 0.0], [0.0, 0.4 * depth]]}
    tank: dict[str, Any] = {"high": [width, depth + room], "walls": str(rng.choice(["mirror", "dummy"]))}
    if room:
        tank["top"] = OPEN
    fluid = [{"low": [0.0, 0.0], "high": [width, depth]}]
    return plain_of(spacing, tank, fluid, pressure, depth, obstacles=[solid])


def plain_of(spacing: float, tank: Any, fluid: Any, pressure: str, depth: float, **more: Any) -> Any:
    """The scene, for three times sqrt(H/g)."""
    end = 3.0 * math.sqrt(depth)
    return from_plain(
        {
            "model": "sph", "duration": end, "frame_every": end / 30.0, "spacing": spacing, "gravity": [0.0, -1.0],
            "liquid": {"density": 1.0}, "tank": tank, "fluid": fluid,
            "method": {"pressure": pressure, "jitter": 0.05}, **more,
        }
    )  # fmt: skip


def gained(frames: Any) -> float:
    """The largest rise of energy less work above the least before, over the weight times the height of the tank."""
    energy = np.array([each.numbers["total_energy"] - each.numbers.get("injected_work", 0.0) for each in frames])
    rise = (energy - np.minimum.accumulate(energy)).max()
    return float(rise / abs(frames[0].numbers["potential_energy"]))


def load_on(solid: Any, depth: float) -> np.ndarray:
    """The exact force of still liquid."""
    if solid.radius is not None:
        return np.array([0.0, math.pi * solid.radius**2])
    (_, _), (width, _), (_, height) = solid.vertices
    return -np.array([height * (depth - 0.5 * height), width * (depth - 0.5 * height)])


def of_rest(frames: Any, scene: Any) -> tuple[float, float]:
    """The error of the mean force of the last third on the obstacle, over its size; and the largest speed at the end,
    over sqrt(g H).
    """
    depth = scene.fluid[0].high[1]
    exact = load_on(scene.obstacles[0], depth)
    late = frames[len(frames) * 2 // 3 :]
    found = np.mean([[each.numbers[f"obstacle0_force_{axis}"] for axis in "xy"] for each in late], axis=0)
    off = float(np.linalg.norm(found - exact) / np.linalg.norm(exact))
    return off, frames[-1].numbers["largest_speed"] / math.sqrt(depth)


def main(count: int) -> None:
    """Worst cases of so many seeds."""
    for pressure in ("tait", "incompressible"):
        rises, offs, speeds, failed = ([] for _ in range(4))
        for seed in range(count // 2):
            try:
                rises.append((gained(list(ecume.simulate(collapsing(seed, pressure)))), seed))
            except Diverged as error:
                failed.append(("collapsing", seed, str(error)[:120]))
            try:
                scene = still(seed, pressure)
                off, speed = of_rest(list(ecume.simulate(scene)), scene)
                offs.append((off, seed))
                speeds.append((speed, seed))
            except Diverged as error:
                failed.append(("still", seed, str(error)[:120]))
        for name, found in (("rise of energy", rises), ("off weight", offs), ("speed", speeds)):
            middle = np.quantile([value for value, _ in found], (0.5, 0.9)).tolist()
            print(pressure, name, "median and 90 %", middle, "worst", sorted(found)[-6:])
        print(pressure, "failed", failed, flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]))
