"""Hydrodynamic interaction of many floats: the time of a step with the matrix and with the grid.

`python benchmarks/flow_of_many.py [FLOATS]` prints a row for each case: drifting floats, a compact raft whose contacts
all push, and Brownian motion. Compilation is not counted. The error is that of the product for forces of random sign.
"""

from __future__ import annotations

import math
import time

import numpy as np

from ecume._quick import parser_of, sized
from ecume.laws.pair_mobility import compact_raft, surface_mobility
from ecume.models import MODELS
from ecume.models.floating.coupled.many_floats import flow_product, place_flow_grid
from ecume.models.model import CROWDED
from ecume.scenes.schema import from_plain

RADIUS = 3e-4
STEPS = sized(10, 1)
FLOATS = sized(10_000, 60)
MOST_IN_MATRIX = 2000
FLOATING = MODELS["floating"]


def scene_of(places: np.ndarray, *, radius: float = RADIUS, brownian: bool = False) -> object:
    """Heavy half-immersed spheres in a viscous liquid."""
    bead = {"radius": radius, "density": 1300.0, "contact_angle": math.pi / 2, "positions": places.tolist()}
    return from_plain({
        "model": "floating", "duration": 1.0, "frame_every": 1.0,
        "liquid": {"density": 1000.0, "viscosity": 0.1, "surface_tension": 0.0728},
        "particles": [bead], "integration": {"integrator": "overdamped"},
        "hydrodynamics": {"interaction": "rotne-prager", "brownian": brownian},
    })  # fmt: skip


def spaced(count: int, cover: float, radius: float) -> np.ndarray:
    """Places that cover this fraction of a square."""
    side, width = math.ceil(math.sqrt(count)), radius * math.sqrt(math.pi / cover)
    places = width * np.stack(np.meshgrid(np.arange(side), np.arange(side)), axis=-1).reshape(-1, 2)[:count]
    return places + 0.1 * (width - 2.0 * radius) * np.random.default_rng(1).uniform(-1.0, 1.0, (count, 2))


def measured(name: str, scene: object) -> str:
    """Wall and processor time of a step, products in contacts, and contacts that push."""
    parameters = FLOATING.parameters(scene)
    state, room = FLOATING.start(scene, parameters), 1.0
    workspace = FLOATING.workspace(parameters, state, room)
    done, wall, own = 0, [], []
    # The first step compiles, and the second finds the impulses without a guess.
    while done < STEPS + 1:
        began, used, products = time.perf_counter(), time.process_time(), state.tally[1]
        if FLOATING.advance(parameters, state, workspace, 1) == CROWDED:
            room *= 2.0
            workspace = FLOATING.workspace(parameters, state, room)
            continue
        wall.append(time.perf_counter() - began)
        own.append(time.process_time() - used)
        done += 1
    pushing = int(np.count_nonzero(workspace.contacts.impulse[: workspace.contacts.total[0]] > 0.0))
    return (
        f"{name:>26} {np.median(wall[1:]):8.3f} {np.median(own[1:]):8.3f} {max(own[1:]):8.3f} "
        f"{state.tally[1] - products:9.0f} {pushing:8d} {state.tally[2]:6.0f}"
    )


def product_error(count: int) -> float:
    """The r.m.s. error of the grid's product beside the matrix."""
    places, dice = spaced(count, 0.5, RADIUS), np.random.default_rng(2)
    force, radius = dice.normal(size=(count, 2)), np.full(count, RADIUS)
    exact = (surface_mobility(places, radius, 0.1) @ force.ravel()).reshape(-1, 2)
    found = flow_product(place_flow_grid(places, radius, 0.1, False), force)
    return float(np.sqrt(np.mean((found - exact) ** 2) / np.mean(exact**2)))


def main(count: int) -> None:
    """Print the table."""
    print(f"{count} floats; error of a product with {min(count, MOST_IN_MATRIX)}:", end=" ")
    print(f"{product_error(min(count, MOST_IN_MATRIX)):.1e}")
    print(f"{'':>26} {'wall s':>8} {'own s':>8} {'most':>8} {'products':>9} {'pushing':>8} {'failed':>6}")
    print(measured("apart, half covered", scene_of(spaced(count, 0.5, RADIUS))))
    print(measured("compact raft", scene_of(1.0005 * RADIUS * compact_raft(count))))
    print(measured("Brownian, half covered", scene_of(spaced(count, 0.5, 1e-6), radius=1e-6, brownian=True)))


if __name__ == "__main__":
    parser = parser_of(__doc__)
    parser.add_argument("floats", metavar="FLOATS", type=int, nargs="?", default=FLOATS)
    main(parser.parse_args().floats)
