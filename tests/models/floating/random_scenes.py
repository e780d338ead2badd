"""Random scenes of floats, drawn from what users draw.

`python -m tests.models.floating.random_scenes 0 2800 200` runs those of 2,800 seeds, some 200 steps each.
"""

from __future__ import annotations

import math
import sys
import warnings
from collections import Counter

import numpy as np

from ecume.errors import Diverged, EcumeError, SceneError
from ecume.models import MODELS
from ecume.models.floating.time_integration.step_size import good_step
from ecume.scenes.schema import from_plain
from ecume.simulation import simulate

LENGTH = 2.7e-3
"""m: the capillary length of water."""


def drawn(seed, steps=200):
    """A scene whose time step is the default one: some hundred steps of it. None where the draw is refused."""
    dice = np.random.default_rng(seed)
    plain = draw(dice)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            scene = from_plain(plain)
            good = min(good_step(MODELS["floating"].parameters(scene), scene), 1e3)
            plain |= {"frame_every": 0.25 * steps * good, "duration": steps * good}
            scene = from_plain(plain)
            MODELS["floating"].parameters(scene)
    except SceneError:
        return None
    return scene


def draw(dice):
    """The tables of a scene."""
    radius = math.exp(dice.uniform(math.log(1e-6), math.log(5e-3)))
    slow = bool(dice.random() < (0.7 if radius < 3e-5 else 0.3))
    plain = {
        "model": "floating", "duration": 1.0, "frame_every": 1.0, "seed": int(dice.integers(1000)),
        "liquid": {"viscosity": float(dice.choice([1e-3, 1e-3, 2e-3, 0.1])), "surface_tension": 0.0728},
        "hydrodynamics": {}, "contacts": {}, "interaction": {},
        "integration": {"integrator": "overdamped" if slow else "velocity-verlet"},
    }  # fmt: skip
    if not slow and dice.random() < 0.15:
        plain["integration"]["integrator"] = str(dice.choice(["semi-implicit-euler", "stormer-verlet", "rk4"]))
    boundary = str(dice.choice(["dish", "dish", "rectangle", "open", "cell"]))
    shaped = boundary != "cell" and dice.random() < 0.15
    floats(dice, plain, radius, boundary, shaped)
    surround(dice, plain, radius, boundary)
    move(dice, plain, radius, slow, shaped)
    return plain


def surround(dice, plain, radius, boundary):
    """The dish or the cell, and the laws of contacts."""
    count = max(len(plain["particles"]), 1)
    room = radius * 2.0 * math.sqrt(1.0 + sum(one.get("count", len(one.get("positions", [])) or 1)
                                              for one in plain["particles"]) + len(plain["rows"]))  # fmt: skip
    size = max(room * float(dice.uniform(2.0, 8.0)), float(dice.choice([1e-3, 5e-3, 1e-2])) * (dice.random() < 0.7))
    if boundary == "cell":
        size = max(size, 8.0 * LENGTH) if dice.random() < 0.9 else size
        plain["cell"] = {"size": [size, size * float(dice.uniform(1.0, 1.5))]}
        if dice.random() < 0.5:
            plain["interaction"]["accuracy"] = 0.05
    if boundary in ("dish", "rectangle"):
        angle = float(dice.choice([math.pi / 4, dice.uniform(0.1, 3.0)]))
        plain["dish"] = {"contact_angle": angle, "restitution": float(dice.uniform(0.0, 1.0))}
        plain["dish"] |= {"radius": size} if boundary == "dish" else {"size": [2.0 * size, 2.4 * size]}
        if dice.random() < 0.3:
            plain["dish"]["law"] = str(dice.choice(["profile", "meniscus", "none"]))
        if dice.random() < 0.15:
            plain["dish"]["image"] = str(dice.choice(["fixed-angle", "pinned"]))
        if dice.random() < 0.1:
            plain["dish"]["friction"] = 0.4
    if dice.random() < 0.15:
        plain["contacts"]["friction"] = float(dice.uniform(0.1, 0.6))
        if dice.random() < 0.3:
            plain["contacts"]["rolling_friction"] = float(dice.uniform(0.05, 0.5))
    elif dice.random() < 0.15:
        plain["contacts"]["law"] = str(dice.choice(["none", "spring-dashpot"]))
    plain["contacts"]["restitution"] = float(dice.choice([0.2, 0.0, 1.0, dice.uniform(0.05, 1.0)]))
    if count == 1 and dice.random() < 0.1:
        plain["interaction"]["method"] = "pair-corrected"


def floats(dice, plain, radius, boundary, shaped):
    """One or two species, by one of the ways in which floats can be given."""
    species = []
    for _ in range(int(dice.choice([1, 1, 2]))):
        own = radius * float(dice.choice([1.0, dice.uniform(0.4, 1.0)]))
        dense = 1000.0 + (0.9 if own > 7e-4 else 1.6) * float(dice.uniform(-900.0, 900.0))
        one = {"radius": own, "density": max(dense, 50.0), "contact_angle": float(dice.uniform(0.5, 2.4))}
        if shaped:
            kind = str(dice.choice(["ellipsoid", "needle", "square", "star"]))
            one["shape"] = {"kind": kind}
            one["shape"] |= {} if kind == "square" else {"width": own * float(dice.uniform(0.3, 1.0))}
            if kind in ("square", "star"):
                del one["contact_angle"]
        if dice.random() < 0.05:
            one["magnetic_moment"] = 1e-7 * (own / 1e-3) ** 3
        species.append(one)
    count, way = (
        int(dice.integers(1, 9)),
        str(dice.choice(["random", "random", "lattice", "ring", "positions", "rows"])),
    )
    spacing, middle = 2.0 * radius * float(dice.choice([1.02, dice.uniform(1.05, 4.0)])), [0.0, 0.0]
    shift = 0.0 if boundary != "cell" else 4.0 * LENGTH
    plain["particles"], plain["rows"] = [], []
    speed = float(dice.choice([0.0, 0.0, dice.uniform(0.0, 30.0) * radius]))
    for number, one in enumerate(species):
        if way == "random":
            plain["particles"].append(one | {"count": count, "velocity": [speed, 0.0]})
        elif way in ("lattice", "ring") and number == 0:
            at = {"spacing": spacing} if way == "lattice" else {"ring_radius": (count + 1) * spacing / 4.0}
            center = {} if boundary == "cell" else {"center": middle}
            plain["particles"].append(one | {"count": count, "placement": way, **at, **center})
        elif way in ("positions", "rows"):
            places = [[shift + spacing * (k % 3), shift + spacing * (k // 3 + 3 * number)] for k in range(count)]
            if way == "positions":
                plain["particles"].append(one | {"positions": places})
            else:
                plain["rows"] += [one | {"x": x, "y": y, "vx": speed, "species_name": f"s{number}"} for x, y in places]


def move(dice, plain, radius, slow, shaped):
    """What moves floats beside one another: flow, noise, activity, a moving dish."""
    water, drive = plain["hydrodynamics"], dice.random()
    friction = 3.0 * math.pi * plain["liquid"]["viscosity"] * radius
    speed = radius * math.exp(dice.uniform(-1.0, 4.0))
    if shaped:
        return
    if drive < 0.25:
        kind = str(dice.choice(["velocity", "shear_rate", "rotation_rate", "extension_rate"]))
        rate = float(dice.choice([-1.0, 1.0])) * math.exp(dice.uniform(-3.0, 1.5))
        plain["flow"] = {kind: [speed, 0.3 * speed] if kind == "velocity" else rate}
    if slow and dice.random() < 0.6 and radius < 1e-4:
        water["brownian"] = True
    if dice.random() < 0.2:
        active = {}
        if dice.random() < 0.5:
            active |= {"force": friction * speed, "persistence": float(math.exp(dice.uniform(-4.0, 1.0)))}
        if dice.random() < 0.7 or not active:
            active |= {"propulsion": friction * speed, "rotational_diffusion": float(dice.uniform(0.0, 2.0))}
        plain["activity"] = active
    if "dish" in plain and dice.random() < 0.08:
        plain["dish"]["motion"] = {"amplitude": 2.0 * radius, "frequency": float(dice.uniform(0.2, 5.0))}
    if not slow and dice.random() < 0.15:
        water["drag"] = "schiller-naumann"
    elif not slow and dice.random() < 0.08:
        water["drag"] = "none"
    elif slow and dice.random() < 0.15:
        water["interaction"] = "rotne-prager"
    elif slow and dice.random() < 0.1:
        water["lubrication"] = {"roughness": 0.01 * radius}
    if not slow and dice.random() < 0.1:
        water["added_mass"] = True


def outcome(seed, steps=200):
    """How the run of a random scene ends: "done", "refused", or the message with which it fails."""
    scene = drawn(seed, steps)
    if scene is None:
        return "refused"
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            for frame in simulate(scene):
                if not np.isfinite(frame.arrays["position"]).all():
                    return "not finite"
    except Diverged as error:
        return str(error)
    except EcumeError as error:
        return f"refused: {type(error).__name__}" if isinstance(error, SceneError) else str(error)
    return "done"


def main(first, last, steps):
    """Print how many scenes of a range of seeds ran, and those that did not."""
    found = Counter()
    for seed in range(first, last):
        told = outcome(seed, steps)
        found[told if told in ("done", "refused", "refused: SceneError") else "failed"] += 1
        if told not in ("done", "refused", "refused: SceneError"):
            print(seed, told, flush=True)
    print(dict(found), flush=True)


if __name__ == "__main__":
    main(*(int(word) for word in sys.argv[1:4]))
