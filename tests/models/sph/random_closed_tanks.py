"""Random small tanks in 2D, closed and open, still or collapsing, with obstacles and bodies.

`python -m tests.models.sph.random_closed_tanks 0 400 30` runs 200 closed and 200 open ones, half of them
incompressible, each for at most 30 s of processor time, and each again with left and right exchanged. It prints one
line a scene.
"""

import math
import sys
import warnings
from collections import Counter
from dataclasses import replace
from time import process_time
from typing import Any, NamedTuple

import numpy as np

from ecume.errors import Diverged, SceneError
from ecume.models.sph.boundaries.rigid_bodies import with_moved_solids
from ecume.models.sph.boundaries.walls import all_braked, all_repelled
from ecume.models.sph.record import SPH
from ecume.models.sph.report.observation import of_solids
from ecume.models.sph.setup.initial_particles import liquid_of
from ecume.models.sph.state import make_state
from ecume.scenes.schema import from_plain
from ecume.simulation import Integration
from tests.models.sph.scenes import OPEN, PERIODIC


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


def disordered(seed: int) -> Any:
    """A full tank of height 1 and periodic along x, from displacements of a fifth of a spacing, without viscosity, for
    six times sqrt(H/g).
    """
    rng = np.random.default_rng([6, seed])
    corners = {"high": [float(rng.uniform(0.7, 1.2)), 1.0]}
    return from_plain(
        {
            "model": "sph", "seed": seed, "duration": 6.0, "frame_every": 0.3, "spacing": 1.0 / rng.integers(9, 12),
            "gravity": [0.0, -1.0], "liquid": {"density": 1.0}, "fluid": [{"low": [0.0, 0.0], **corners}],
            "tank": {**corners, "left": PERIODIC, "right": PERIODIC},
            "method": {"jitter": 0.2, "artificial_viscosity": 0.0},
        }
    )  # fmt: skip


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


def risen(frames: Any) -> float:
    """The same with work from outside only: what the numerical method adds counts as a gain."""
    energy = np.array([
        each.numbers["total_energy"] - each.numbers.get("injected_work", 0.0) + each.numbers.get("numerical_work", 0.0)
        for each in frames
    ])  # fmt: skip
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


class Balance(NamedTuple):
    """How well the forces on solids agree with the momentum of the liquid, step by step, and the frames of the run."""

    frames: list[Any]
    worst: np.ndarray
    """(d,) the largest difference of momentum and impulses, over M sqrt(g H)"""
    jumps: list[tuple[float, float, float]]
    """the steps with the largest differences: time, and the difference along x and y"""


def balance(scene: Any, depth: float, limit: float = math.inf) -> Balance:
    """The forces of a run, recorded after each step, against the change of the liquid's momentum. Raises Slow after
    `limit` s of processor.
    """
    end = process_time() + limit
    parameters = SPH.parameters(scene)
    run = Integration(SPH, parameters, SPH.start(scene, parameters), 0.0)
    time, d, incompressible = parameters.time_step, parameters.dimension, parameters.projection is not None
    state, rows, before, frames = run.state, [], None, [run.observe()]
    mass, each = float(state.mass.sum()), parameters.steps_per_frame
    for step in range(1, scene.frames * each + 1):
        earlier = (state.velocity * state.mass).sum(axis=1)
        run.go(1)
        if process_time() > end:
            raise Slow(f"stopped at {step / (scene.frames * each):.0%} after {step} steps")
        state = run.state
        force, mean = at_this_step(run), state.struck[:, :d].sum(axis=0)
        at_once = 0.0 * mean if incompressible else force - mean
        impulse = time * (mean + 0.5 * (at_once + (at_once if before is None else before)))
        gained = (state.velocity * state.mass).sum(axis=1) - earlier - mass * parameters.gravity * time
        rows.append(gained + impulse)
        before = at_once
        if step % each == 0:
            frames.append(run.observe())
    missed = np.array(rows) / (mass * math.sqrt(depth))
    largest = np.argsort(-np.abs(missed).max(axis=1))[:3]
    jumps = [(float(k * time), *missed[k].tolist()) for k in largest]
    return Balance(frames, np.abs(np.cumsum(missed, axis=0)).max(axis=0), jumps)


def at_this_step(run: Integration) -> np.ndarray:
    """The force (d,) that frames record now on all solids together."""
    now = with_moved_solids(run.parameters, run.state)
    numbers, _ = of_solids(now, run.state, run.workspace, [*all_repelled(now, run.state), *all_braked(now, run.state)])
    return np.array([sum(value for name, value in numbers.items() if name.endswith(f"_force_{axis}")) for axis in "xy"])


def solved_exactly(scene: Any) -> Any:
    """An incompressible scene whose pressure is solved to rounding: by default rounding decides about an iteration, and
    both solutions differ by the tolerance, from which splashes grow.
    """
    if scene.method.pressure != "incompressible":
        return scene
    exact = replace(scene.integration, pressure_tolerance=1e-9, pressure_iterations=5000)
    return replace(scene, integration=exact)


def mirrored(scene: Any) -> Any:
    """The scene with left and right exchanged."""
    width = scene.tank.high[0]

    def turned(solid: Any) -> Any:
        if solid.vertices:
            return replace(solid, vertices=[[width - x, y] for x, y in solid.vertices])
        if solid.center is not None:
            return replace(solid, center=[width - solid.center[0], *solid.center[1:]])
        ends = width - solid.high[0], width - solid.low[0]
        return replace(solid, low=[ends[0], *solid.low[1:]], high=[ends[1], *solid.high[1:]])

    return replace(
        scene,
        **{name: tuple(turned(each) for each in getattr(scene, name)) for name in ("obstacles", "bodies", "fluid")},
    )


def asymmetry(scene: Any, steps: int = 100) -> tuple[float, str]:
    """The largest difference of numbers of the mirrored tank after these steps, relative to the largest number of its
    kind, and the name of that number.
    """
    found = []
    for each in (scene, mirrored(scene)):
        parameters = SPH.parameters(each)
        liquid = liquid_of(scene, parameters.material)
        if found:
            liquid.position[0] = scene.tank.high[0] - liquid.position[0]
            liquid.velocity[0] *= -1.0
        state = make_state(parameters, liquid)
        run = Integration(SPH, parameters, state, 1.0)
        while int(run.state.step[0]) < steps:
            run.go(steps - int(run.state.step[0]))
        found.append(run.observe().numbers)
    one, other = found
    other = {exchanged(name): value for name, value in other.items()}
    scale = max(abs(value) for name, value in one.items() if "_force_" in name)
    worst = (0.0, "-")
    for name, value in one.items():
        if "_force_" in name:
            sign = -1.0 if name.endswith("_x") else 1.0
            worst = max(worst, (abs(value - sign * other[name]) / scale, name))
        elif name in ("kinetic_energy", "potential_energy", "largest_speed"):
            worst = max(worst, (abs(value - other[name]) / abs(value), name))
    return worst


def exchanged(name: str) -> str:
    """The name of the same number in the mirrored tank."""
    for side, other in (("left", "right"), ("right", "left")):
        if name.startswith(f"{side}_"):
            return other + name[len(side) :]
    return name


def filled(seed: int, pressure: str) -> Any:
    """Closed: 94 to 100 % of the height is full, around one or two solids, which may touch each other, a wall, the
    floor or a corner; and a body in half of those that may have one.
    """
    rng = np.random.default_rng([4, seed])
    width, height, spacing = float(rng.uniform(0.8, 1.6)), 1.0, 1.0 / 16.0
    size = float(rng.uniform(2.5, 4.0)) * spacing
    first: dict[str, Any] = [
        {"center": [0.5 * width, size], "radius": size},
        {"center": [size, 0.5], "radius": size},
        {"low": [0.0, 0.0], "high": [1.5 * size, size]},
        {"vertices": [[width - 2.0 * size, 0.0], [width, 0.0], [width, 2.0 * size]]},
        {"low": [0.3 * width, 0.4], "high": [0.3 * width + 1.5 * size, 0.4 + size]},
        {"center": [0.5 * width, 0.0], "radius": size},
    ][int(rng.integers(6))]
    solids = [first]
    if "center" in first and rng.uniform() < 0.5:
        x, y = first["center"]
        angle = float(rng.uniform(0.2, 1.2))
        solids.append({"center": [x + 2.0 * size * math.cos(angle), y + 2.0 * size * math.sin(angle)], "radius": size})
    fluid = [{"low": [0.0, 0.0], "high": [width, float(rng.choice([1.0, rng.uniform(0.94, 1.0)]))]}]
    tank = {"high": [width, height], "walls": str(rng.choice(["mirror", "dummy"]))}
    bodies = []
    if pressure == "tait" and rng.uniform() < 0.5:
        left = first.get("center", [0.0])[0] == 0.5 * width
        middle = [1.2 * size if left else width - 1.2 * size, 0.7]
        bodies = [{"center": middle, "radius": 0.8 * size, "density": float(rng.uniform(0.8, 1.3))}]
    return plain_of(spacing, tank, fluid, pressure, 1.0, obstacles=solids, bodies=bodies)


KINDS = {"still": still, "collapsing": collapsing, "filled": filled, "opened": opened}
CLOSED = ("still", "collapsing", "filled")
BOUNDS = {
    "gain": 2e-3, "rise": 2e-3, "lost": 0.5, "speed": 0.03, "load": 0.01, "wall": 0.01, "weight": 0.01,
    "momentum": 0.03, "mirror": 1e-5,
}  # fmt: skip
"""What a scene may miss: of its potential energy; particles; of sqrt(gH); of the load on a solid, on a wall, of the
weight; of M sqrt(gH), 1 % of what gravity gives in a run; and of numbers of the mirrored tank.
"""


class Slow(Exception):
    """More time than a test may take."""


def drawn(seed: int) -> tuple[str, str]:
    """The kind of tank and the method of a seed: every other one is closed."""
    kind = "opened" if seed % 2 else CLOSED[seed // 4 % 3]
    return kind, ("tait", "incompressible")[seed // 2 % 2]


def measured(kind: str, pressure: str, seed: int, limit: float) -> dict[str, float]:
    """How much a scene misses, by the names of `BOUNDS`. Raises Slow after `limit` s of processor."""
    scene = KINDS[kind](seed, pressure)
    depth = max(region.high[1] for region in scene.fluid)
    run = balance(scene, depth, limit)
    frames, missed = run.frames, {"momentum": float(run.worst.max())}
    missed |= {"gain": gained(frames), "rise": risen(frames), "lost": frames[-1].numbers["particles_lost"]}
    if kind == "still":
        missed["load"], missed["speed"] = of_rest(frames, scene)
        missed |= {"wall": of_wall(frames, depth), "weight": unbalanced(frames)}
    missed["mirror"] = asymmetry(solved_exactly(scene))[0]
    return missed


def outcome(kind: str, pressure: str, seed: int, limit: float = math.inf) -> tuple[str, dict[str, Any]]:
    """How a scene ends: "done" with what it misses, "refused", "diverged" or "slow" with the reason."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return "done", measured(kind, pressure, seed, limit)
    except SceneError as error:
        return "refused", {"reason": str(error)}
    except Diverged as error:
        return "diverged", {"reason": str(error)}
    except Slow as error:
        return "slow", {"reason": str(error)}


def main(first: int, last: int, limit: float) -> None:
    """Print how each of so many seeds ends and what it misses, and how many miss what, by kind."""
    counts: Counter[str] = Counter()
    for seed in range(first, last):
        began, (kind, pressure) = process_time(), drawn(seed)
        word, found = outcome(kind, pressure, seed, limit)
        wrong = [name for name, value in found.items() if word == "done" and not value < BOUNDS[name]]
        counts.update([f"{kind} {pressure}: {each}" for each in (word, *wrong)])
        scene = KINDS[kind](seed, pressure)
        values = " ".join(f"{name}={value:.1e}" if word == "done" else value for name, value in found.items())
        line = (
            f"{seed} {kind} {pressure} {scene.tank.walls} {solids_in(scene)} {word} {','.join(wrong) or '-'} {values}"
        )
        print(f"{line} {process_time() - began:.1f} s", flush=True)
    print(dict(sorted(counts.items())), flush=True)


def solids_in(scene: Any) -> str:
    """The kinds of solids of a scene."""
    kinds = [
        "wedge" if each.vertices else "disc" if each.radius is not None else "box"
        for each in (*scene.obstacles, *scene.bodies)
    ]
    return "+".join(kinds) or "-"


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]), float(sys.argv[3]))
