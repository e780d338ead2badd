"""Random scenes of floats, drawn from what users draw, that run to their ends.

`python -m tests.models.floating.random_scenes 0 2800 2 4` runs the scenes of 2,800 seeds with two further options, each
for its whole duration of 1 to 30 s, or until it has used 4 s of processor time: then it is cut, and counted as such. A
scene fails if `check` calls its time step good and it diverges, ends with an error, leaves a number that is not finite,
or breaks an invariant of the model, such as that of the energy. Scenes without further options share what is compiled.
Most others are combinations of options that no other has, and are compiled for ten seconds (or never, with
`NUMBA_DISABLE_JIT=1`, where a step takes milliseconds).
"""

from __future__ import annotations

import math
import sys
import time
import traceback
import warnings
from collections import Counter

import numpy as np

from ecume.errors import Diverged, EcumeError, SceneError
from ecume.models import MODELS
from ecume.models.floating.time_integration.step_size import good_step
from ecume.models.invariants import NumberHistory, with_own
from ecume.scenes.schema import from_plain
from ecume.simulation import extended, moments

LENGTH = 2.7e-3
"""m: the capillary length of water."""


def drawn(seed, steps, further):
    """A scene whose time step is the default one, some steps of it (or its whole duration, without their number), and
    the laws of the user in it. Most have this number of `further` options. None where the draw is refused.
    """
    dice = np.random.default_rng(seed)
    plain = draw(dice)
    if further:  # tables of corrected pairs take minutes without compilation
        plain["interaction"].pop("method", None)
    laws = add_options(dice, plain, further) if dice.random() < 0.6 else []
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            if steps is None:
                return from_plain(plain | whole(seed)), laws
            scene = from_plain(plain)
            good = min(good_step(MODELS["floating"].parameters(scene), scene), 1e3)
            scene = from_plain(plain | {"frame_every": 0.25 * steps * good, "duration": steps * good})
            # In a growing flow the default step depends on the duration, too, and it is shorter with a stiff law.
            model = extended(MODELS["floating"], scene, laws)
            many = 4 * model.parameters(scene).steps_per_frame / steps
            if many > 2.0:
                good /= many
                scene = from_plain(plain | {"frame_every": 0.25 * steps * good, "duration": steps * good})
    except SceneError:
        return None
    return scene, laws


def whole(seed):
    """The duration of a scene and the time between its frames (s)."""
    duration = float(f"{math.exp(np.random.default_rng([seed, 1]).uniform(0.0, math.log(30.0))):.3g}")
    return {"duration": duration, "frame_every": 0.05 * duration}


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
    """Add one or two species in one of the ways in which floats can be given."""
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
    """Add causes of motion: flow, noise, activity, a moving dish."""
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


def well(distance, parameters):
    """A force between two floats (N) that binds them weakly at a distance of three radii."""
    radius = 0.5 * (parameters.radius_i + parameters.radius_j)
    apart = distance / radius - 3.0
    return -1e-3 * parameters.surface_tension * radius * apart * math.exp(-apart * apart)


def add_options(dice, plain, further):
    """Add further options; returns the laws of the user."""
    laws = []
    for option in sorted(dice.choice(len(OPTIONS), further, replace=False)):
        OPTIONS[option](dice, plain, laws)
    return laws


def powers(dice, low, high):
    """A number between two powers of ten."""
    return float(10.0 ** dice.uniform(low, high))


def largest_radius(plain):
    """The largest radius of a scene (m)."""
    return max(one["radius"] for one in [*plain["particles"], *plain["rows"]])


def add_waves(dice, plain, laws):
    """Waves of one or two sources on each float."""
    radius = largest_radius(plain)
    sources = [
        {"place": [float(dice.uniform(-0.5, 0.5)) * radius, 0.0], "force": 72e-6 * radius * powers(dice, -1.0, 2.0)}
        for _ in range(int(dice.integers(1, 3)))
    ]
    plain["waves"] = {"frequency": float(dice.uniform(20.0, 300.0)), "sources": sources}


def add_field(dice, plain, laws):
    """A magnetic field that may oscillate or rotate."""
    parts = dice.choice([0.0, 1e-3, 5e-3], (2, 3)).tolist()
    plain["magnetic_field"] = {
        "constant": parts[0], "amplitude": parts[1], "frequency": float(dice.uniform(0.1, 20.0)),
        "phase": [0.0, 0.5 * math.pi, 0.0], "susceptibility": float(dice.choice([0.0, 1.0, 1e5])),
    }  # fmt: skip


def add_surfactant(dice, plain, laws):
    """Floats that release surfactant, on a coarse grid."""
    dish = plain.get("dish", {})
    if "radius" in dish or "size" in dish:
        spacing = {"spacing": (dish["radius"] if "radius" in dish else 0.5 * max(dish["size"])) / 4.0}
    else:
        spacing = {}
    plain["surfactant"] = {
        "diffusivity": powers(dice, -7.0, -4.0), "tension_slope": powers(dice, -1.0, 1.0),
        "loss_rate": float(dice.choice([0.0, 1.0])), "sources": [{"release": powers(dice, -15.0, -11.0)}],
        **spacing,
    }  # fmt: skip


def add_barrier(dice, plain, laws):
    """A moving side of a rectangular dish."""
    if "dish" in plain and "size" in plain["dish"]:
        width = plain["dish"]["size"][0]
        plain["dish"]["barrier"] = {
            "side": str(dice.choice(["left", "right"])), "start": 0.02 * width, "stop": 0.1 * width,
            "velocity": float(dice.choice([0.01, 0.1, 1.0])) * largest_radius(plain),
        }  # fmt: skip


def add_polygon(dice, plain, laws):
    """A dish with corners."""
    if "dish" in plain and "radius" in plain["dish"]:
        far = 2.0 * plain["dish"].pop("radius")
        turn = 2.0 * math.pi / int(dice.integers(3, 7))
        corners = np.arange(round(2.0 * math.pi / turn)) * turn
        plain["dish"]["vertices"] = (far * np.column_stack([np.cos(corners), np.sin(corners)])).tolist()


def add_table_of_flow(dice, plain, laws):
    """A flow given at nodes."""
    far = 20.0 * largest_radius(plain)
    speed = largest_radius(plain) * math.exp(dice.uniform(-2.0, 3.0))
    parts = (speed * dice.normal(size=(2, 4, 5))).tolist()
    plain["flow"] = {"nodes": {"low": [-far, -far], "high": [far, far], "vx": parts[0], "vy": parts[1]}}


def add_discs(dice, plain, laws):
    """Discs instead of spheres."""
    for one in [*plain["particles"], *plain["rows"]]:
        if "shape" not in one:
            one.pop("contact_angle", None)
            rim = "bottom" if one["density"] < 1000.0 else "top"
            one["disc"] = {"thickness": 0.4 * one["radius"], "rim": rim, "tilting": bool(dice.random() < 0.5)}


def add_sizes(dice, plain, laws):
    """Floats of several sizes."""
    for one in plain["particles"]:
        if "shape" not in one and "positions" not in one:
            kind = str(dice.choice(["normal", "lognormal", "uniform"]))
            one["radius"] = {"distribution": kind, "mean": one["radius"], "spread": float(dice.uniform(0.01, 0.3))}


def add_method(dice, plain, laws):
    """Another sum or law of the attraction."""
    plain["interaction"] |= [
        {"method": "multipole", "order": 2}, {"summation": "grid"}, {"precision": "single"}, {"law": "none"},
        {"charge": "linear"}, {"law": "one-sided-legacy"},
    ][int(dice.integers(6))]  # fmt: skip


def add_theory(dice, plain, laws):
    """The defaults of another theory."""
    plain["theory"] = str(dice.choice(["linear", "legacy-2022"]))


def add_oil(dice, plain, laws):
    """A light liquid above the heavy one, or a liquid by its name."""
    plain["liquid"] = [
        {"gas_density": float(dice.uniform(700.0, 950.0)), "gas_viscosity": 5e-3, "surface_tension": 0.05},
        {"name": "water", "temperature": 320.0}, {"gas_density": 1.2, "gas_viscosity": 1.8e-5},
    ][int(dice.integers(3))]  # fmt: skip


def add_well(dice, plain, laws):
    """A law of the user that binds floats."""
    laws.append(well)


def add_films(dice, plain, laws):
    """Films between floats, with the flow of neighbors."""
    plain["hydrodynamics"] |= {
        "interaction": "rotne-prager",
        "lubrication": {"roughness": 1e-3 * largest_radius(plain)},
    }
    plain["integration"]["integrator"] = "overdamped"


def add_memory(dice, plain, laws):
    """Add a random force with memory to the other causes of motion."""
    push = 3.0 * math.pi * 1e-3 * largest_radius(plain) ** 2 * math.exp(dice.uniform(-1.0, 4.0))
    active = {"force": push, "persistence": powers(dice, -3.0, 1.0), "torque": float(dice.choice([0.0, 1e-20]))}
    plain["activity"] = plain.get("activity", {}) | active


def add_weight(dice, plain, laws):
    """Change gravity, or make it negligible."""
    plain["gravity"] = float(dice.choice([0.1, 1.62, 30.0]))


OPTIONS = (
    add_waves, add_field, add_surfactant, add_barrier, add_polygon, add_table_of_flow, add_discs, add_method,
    add_theory, add_oil, add_well, add_films, add_memory, add_weight, add_sizes,
)  # fmt: skip
"""In the order in which they are added: the last one makes tables of the radii."""


def judged_good(scene):
    """Whether `check` calls the time step of a scene good."""
    return any(name == "time step" and said.startswith("good") for name, _, said in MODELS["floating"].summary(scene))


def broken(scene, laws, seconds):
    """The first fault of a run to its end: a number that is not finite, or an invariant that is broken; or None. A run
    that takes more than some seconds of processor time is cut.
    """
    rules, first, least, largest, started = None, None, None, None, None
    for moment in moments(scene, extra_laws=laws):
        if moment.step and started is None:
            started = time.process_time()  # after the first steps, with which the run is compiled
        if started is not None and not moment.ended and time.process_time() - started > seconds:
            return f"{CUT} at {moment.done:.1%} after {moment.taken} steps"
        if moment.frame is None:
            continue
        if not all(np.isfinite(moment.frame.arrays[name]).all() for name in ("position", "velocity")):
            return "not finite"
        rules = rules or MODELS["floating"].invariants(scene, moment.parameters)
        now = with_own(moment.frame.numbers) | {"step": float(moment.taken)}
        first, least, largest = first or now, least or dict(now), largest or dict(now)
        for name, number in now.items():
            least[name], largest[name] = min(least[name], number), max(largest[name], number)
        for rule in rules:
            if not (value := rule.value(NumberHistory(first, now, least, largest))) <= rule.limit:
                return f"invariant {rule.name}: {value:.3g} above {rule.limit:g} at step {moment.taken}"
    return None


CUT = "cut"
REFUSED = ("refused", "refused at the start", "not good")
"""The outcomes of scenes that do not run."""


def outcome(seed, steps=None, further=2, seconds=math.inf):
    """The outcome of the run of a random scene: "done", one of `REFUSED`, where it was cut, or the message with which
    it fails.
    """
    found = drawn(seed, steps, further)
    if found is None:
        return REFUSED[0]
    scene, laws = found
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            if not judged_good(scene):
                return REFUSED[2]
        except SceneError:
            return REFUSED[1]
        except Exception:
            return f"check: {traceback.format_exc(limit=-2)}"
        try:
            return broken(scene, laws, seconds) or "done"
        except SceneError:
            return REFUSED[1]
        except (Diverged, EcumeError) as error:
            return f"{type(error).__name__}: {error}"
        except Exception:
            return traceback.format_exc(limit=-2)


def main(first, last, further, seconds):
    """Print how many scenes of a range of seeds ran to their ends, and those that did not."""
    found = Counter()
    for seed in range(first, last):
        ended = outcome(seed, None, further, seconds)
        kind = CUT if ended.startswith(CUT) else ended if ended in ("done", *REFUSED) else "failed"
        found[kind] += 1
        if kind in (CUT, "failed"):
            print(seed, ended, flush=True)
        if (seed + 1 - first) % 50 == 0:
            print(seed + 1, dict(found), flush=True)
    print(dict(found), flush=True)


if __name__ == "__main__":
    main(*(int(word) for word in sys.argv[1:5]))
