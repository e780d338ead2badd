"""Random small tanks in 2D, closed and open, still or collapsing, with obstacles and bodies; by hand with many seeds:
`python -m tests.models.sph.random_closed_tanks 200`.
"""

import math
import sys
from typing import Any

import numpy as np

import ecume
from ecume.errors import Diverged
from ecume.scenes.schema import from_plain
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


def opened(seed: int, pressure: str) -> Any:
    """Open: a column that collapses onto an obstacle, or a pool around it, and bodies, which float, sink or fall."""
    rng = np.random.default_rng([3, seed])
    width, spacing = float(rng.uniform(1.0, 2.0)), 1.0 / int(rng.integers(10, 16))
    collapses = bool(rng.uniform() < 0.5)
    depth = float(rng.uniform(0.5, 1.0))
    liquid = float(rng.uniform(0.3, 0.45)) * width if collapses else width
    tank = {"high": [width, 3.0], "walls": str(rng.choice(["mirror", "dummy"])), "top": OPEN}
    middle, size = float(rng.uniform(0.65, 0.8)) * width, float(rng.uniform(0.1, 0.16))
    obstacle: dict[str, Any] = [
        {"center": [middle, float(rng.choice([size, 0.0, 2.5 * size]))], "radius": size},
        {"low": [middle - size, 0.0], "high": [middle + size, 1.5 * size]},
        {"vertices": [[width - 0.35, 0.0], [width, 0.0], [width, float(rng.uniform(0.1, 0.35))]]},
    ][int(rng.integers(3))]
    radius = min(float(rng.uniform(2.5, 4.0)) * spacing, 0.2)
    center = [0.25 * width, float(rng.choice([radius + 0.02, 0.4 * depth, 0.95 * depth, depth + 2.0 * radius]))]
    body: dict[str, Any] = {"center": center, "radius": radius}
    if rng.uniform() < 0.4:
        body = {"low": [c - 0.9 * radius for c in center], "high": [c + 0.9 * radius for c in center]}
    body["density"] = float(rng.uniform(0.4, 3.0))
    fluid = [{"low": [0.0, 0.0], "high": [liquid, depth]}]
    bodies = [body] if pressure == "tait" else []  # refused otherwise
    return plain_of(spacing, tank, fluid, pressure, depth, obstacles=[obstacle], bodies=bodies)


def unbalanced(frames: Any) -> float:
    """The mean vertical force on all solids, less the weight of the liquid and its change of momentum, over the weight;
    from one third of the time on. Frames see single instants of it.
    """
    late = [each.numbers for each in frames[len(frames) // 3 :]]
    down = np.mean([sum(value for key, value in each.items() if key.endswith("_force_y")) for each in late[1:]])
    weight = float(frames[0].arrays["mass"].sum())
    time = frames[-1].time - frames[len(frames) // 3].time
    return float(abs(-down - weight - (late[-1]["momentum_y"] - late[0]["momentum_y"]) / time) / weight)


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


def of_wall(frames: Any, depth: float) -> float:
    """The relative error of the mean horizontal force of the last third on the right wall, which no solid touches."""
    late = frames[len(frames) * 2 // 3 :]
    return float(abs(np.mean([each.numbers["right_force_x"] for each in late]) / (0.5 * depth**2) - 1.0))


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
        open_tanks(count, pressure)


def open_tanks(count: int, pressure: str) -> None:
    """The same of open tanks."""
    found, failed = [], []
    for seed in range(count):
        scene = opened(seed, pressure)
        try:
            frames = list(ecume.simulate(scene))
        except Diverged as error:
            failed.append((seed, str(error)[:120]))
            continue
        found.append((gained(frames), unbalanced(frames), frames[-1].numbers["particles_lost"], seed))
    for place, name in enumerate(("rise of energy", "unbalanced force", "particles lost")):
        rows = sorted((row[place], row[3]) for row in found)
        middle = np.quantile([value for value, _ in rows], (0.5, 0.9)).tolist()
        print(pressure, "open,", name, "median and 90 %", middle, "worst", rows[-6:])
    print(pressure, "open, failed", failed, flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]))
