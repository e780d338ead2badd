"""Random scenes of soft spheres, drawn from what users draw: clusters, cells, walls, and every option of each.

`python -m tests.models.soft.random_scenes 0 500 10` runs those of 500 seeds, each for at most 10 s of processor time,
and each again with its spheres in another order, rotated, and continued from its middle. It prints one line a scene.
The scenes of `draw` have a few spheres; those of `drawn`, which it runs, have more in most, and up to three `OPTIONS`.
"""

from __future__ import annotations

import contextlib
import math
import signal
import sys
import time
import traceback
import warnings
from collections import Counter

import numpy as np
from scipy.spatial.transform import Rotation

from ecume.analysis.rheology import stress_tensor
from ecume.errors import Diverged, EcumeError, SceneError
from ecume.models.soft import SOFT
from ecume.models.soft.integration.dirk_schemes import error_of_run
from ecume.models.soft.setup import GLUE, places
from ecume.scenes.schema import from_plain, to_plain
from ecume.scenes.soft import SIDES, dimensions_of, sides_of
from ecume.scenes.soft.protocol import EXCLUSIVE
from ecume.simulation import moments

MOST_STEPS = 1500
"""A run that takes more is given up: "slow"."""
PATIENCE = 3.0
"""The time that the same scene may take in another order or rotated, over that of the first run."""
ROUNDED = 1e-10
"""Of modulus times radius squared: smaller forces are rounding of positions, and so are their energies."""

LEAN = 1e2
"""Of the rounding of a pressure: a millionth of so small a stress, 1e-14 of the modulus, is the rounding of the largest
term of the sum over contacts.
"""


def draw(dice):
    """The tables of a scene."""
    radius, modulus, viscosity = (float(10.0 ** dice.uniform(*powers)) for powers in ((-6, -2), (3, 6), (-3, 1)))
    dimensions = int(dice.choice([2, 2, 3]))
    place = str(dice.choice(["cluster", "cell", "cell", "cell", "walls"]))
    plain = {
        "model": "soft", "seed": int(dice.integers(1000)), "liquid": {"viscosity": viscosity},
        "rotation": bool(dice.random() < 0.6), "films": films(dice, radius, modulus, viscosity),
        "hydrodynamics": {"drag": str(dice.choice(["none", "stokes"]))},
        "integration": integration(dice),
    }  # fmt: skip
    plain["particles"] = spheres(dice, radius, modulus)
    plain["long_range_forces"] = long_range(dice, radius, modulus)
    if plain["films"]["surface"] == "bubble" or dice.random() < 0.1:
        plain["liquid"]["surface_tension"] = modulus * radius
    rate = modulus / viscosity * float(10.0 ** dice.uniform(-6, -3))
    strain = float(dice.choice([0.01, 0.03, 0.1]))
    plain["duration"] = strain / rate
    plain["frame_every"] = plain["duration"] / 4.0
    {"cluster": cluster, "cell": cell, "walls": walls}[place](
        dice, plain, (radius, modulus, dimensions), (rate, strain)
    )
    return plain


def films(dice, radius, modulus, viscosity):
    """The contact laws."""
    found = {
        "surface": str(dice.choice(["hertz", "hertz", "hertz", "bubble"])),
        "interface": str(
            dice.choice(["rigid", "rigid", "rigid", "half-mobile", "mobile", "drop", "elastohydrodynamic"])
        ),
        "prefactors": str(dice.choice(["paper", "physical"])),
        "tangential_law": str(dice.choice(["potential", "potential", "secant"])),
    }
    found |= {"output": "vectors"}
    if dice.random() < 0.3:
        found["friction"] = str(dice.choice(["coulomb", "critical-load"]))
        found |= {"roughness": radius * float(dice.choice([0.01, 0.05])), "friction_coefficient": 0.3}
        found["critical_load"] = 1e-5 * modulus * radius**2
    if dice.random() < 0.3:
        found["tension_law"] = str(dice.choice(["gap", "symmetric", "cavitation"]))
        found["cavitation_pressure"] = 0.05 * modulus
    if dice.random() < 0.2:
        found["cutoff"] = radius * float(dice.uniform(0.2, 0.8))
    return found


def integration(dice):
    """The scheme, its tolerance and the solver."""
    return {
        "integrator": str(dice.choice(["esdirk4", "tr-bdf2"])),
        "tolerance": float(dice.choice([1e-3, 1e-4, 1e-6])),
        "solver": str(dice.choice(["auto", "auto", "dense", "direct", "iterative"])),
    }


def long_range(dice, radius, modulus):
    """The force across the films."""
    law, strength = str(dice.choice(["none", "none", "steric", "dlvo"])), modulus * radius**2
    if law == "steric":
        part = float(10.0 ** dice.uniform(-5, -3))
        return {"law": law, "steric_strength": part * strength, "steric_length": 0.01 * radius}
    if law == "dlvo":
        length = 0.01 * radius
        return {
            "law": law, "hamaker_constant": 1e-7 * strength * length, "double_layer_strength": 1e-4 * strength,
            "debye_length": length, "smallest_separation": 0.01 * length,
        }  # fmt: skip
    return {"law": law}


def spheres(dice, radius, modulus):
    """One or two species, equal or with a distribution of sizes."""
    found = []
    for number in range(int(dice.choice([1, 2, 2]))):
        own = radius * (1.0 if number == 0 else float(dice.uniform(0.6, 1.0)))
        one = {"radius": own, "modulus": modulus * float(dice.choice([1.0, 3.0])), "count": int(dice.integers(1, 5))}
        if dice.random() < 0.2:
            kind = str(dice.choice(["normal", "lognormal", "uniform"]))
            one["radius"] = {"distribution": kind, "mean": own, "spread": float(dice.uniform(0.05, 0.3))}
        found.append(one)
    found[0]["count"] += 2
    return found


def cluster(dice, plain, sizes, course):
    """A few spheres side by side, moved by forces or torques, or settling on a wall."""
    radius, modulus, dimensions = sizes
    count, gap = 2 + int(dice.integers(4)), radius * float(10.0 ** dice.uniform(-3, -0.7))
    step = 2.0 * radius + gap
    lattice = np.array([(i + 0.5 * (j % 2), 0.87 * j, 0.0) for j in range(3) for i in range(3)])
    places = step * (lattice[dice.permutation(9)[:count]])[:, :dimensions]
    places[:, 1] += radius + gap
    force = dice.normal(size=(count, dimensions)) * modulus * radius**2 * float(10.0 ** dice.uniform(-6, -3))
    settles = dice.random() < 0.3
    if plain["hydrodynamics"]["drag"] == "none" and not settles:
        force -= force.mean(axis=0)
        arm = places - places.mean(axis=0)
        if plain["rotation"] and dimensions == 2:
            moment = float((arm[:, 0] * force[:, 1] - arm[:, 1] * force[:, 0]).sum())
            size = float((arm**2).sum())
            force -= moment / size * np.stack([-arm[:, 1], arm[:, 0]], axis=1)
        elif plain["rotation"]:
            force = arm * (force[0, 0] / radius)
            force -= force.mean(axis=0)
    if settles:
        plain["walls"] = [{"side": "bottom", "position": 0.0}]
        if dice.random() < 0.5:
            plain["gravity"] = 9.81
            plain["liquid"]["density"] = 1000.0
            force *= 0.0
        else:
            force[:, 1] = -np.abs(force[:, 1])
    plain["particles"] = [
        {"radius": radius * (1.0 if dice.random() < 0.7 else float(dice.uniform(0.7, 1.0))), "modulus": modulus,
         "density": min(1000.0 + 1e-3 * modulus / 9.81 / radius, 9e4), "positions": [place.tolist()],
         "force": pull.tolist()}
        for place, pull in zip(places, force, strict=True)
    ]  # fmt: skip
    if "gravity" not in plain:
        for one in plain["particles"]:
            del one["density"]
    if plain["rotation"] and dice.random() < 0.4 and plain["hydrodynamics"]["drag"] == "stokes":
        plain["particles"][0]["torque"] = [1e-6 * modulus * radius**3] * (1 if dimensions == 2 else 3)
    if dice.random() < 0.3:
        plain["protocol"] = [{"time": 0.0, "load": 0.0}, {"time": 0.3 * plain["duration"], "load": 1.0}]


def cell(dice, plain, sizes, course):
    """A periodic cell whose shear and size are controlled by values or stresses."""
    radius, modulus, dimensions = sizes
    rate, strain = course
    filled = float(dice.choice([0.5, 0.65, 0.75, 0.8])) * (1.0 if dimensions == 2 else 0.7)
    plain["cell"] = {"size": [1.0, float(dice.choice([1.0, 0.8])), 1.0][:dimensions], "volume_fraction": filled}
    stress = modulus * float(10.0 ** dice.uniform(-5, -2.5)) * (radius if dimensions == 2 else 1.0)
    first, last = {"time": 0.0}, {"time": plain["duration"]}
    shear = str(dice.choice(["none", "strain", "shear_rate", "shear_stress", "oscillation", "jump", "rate_steps"]))
    if shear == "strain":
        last["strain"] = strain
    elif shear == "shear_rate":
        first["shear_rate"] = rate * float(dice.choice([1.0, -1.0]))
    elif shear == "shear_stress":
        first["shear_stress"] = 0.3 * stress
    elif shear == "oscillation":
        first["oscillation"] = {"frequency": 2.0 / plain["duration"], "amplitude": 0.1 * strain}
    elif shear == "rate_steps":
        first["rate_steps"] = {"rates": [rate, 3.0 * rate], "strain": 0.5 * strain}
    size = str(dice.choice(["none", "scale", "height_rate", "normal_stress", "pressure"]))
    if size == "scale":
        last["scale"] = 1.0 - 0.2 * strain
    elif size == "height_rate":
        first["height_rate"] = -0.2 * rate
    elif size != "none":
        first[size] = stress
    plain["protocol"] = [first]
    if last.keys() - {"time"}:
        plain["protocol"].append(last)
    if shear == "jump":
        middle = 0.4 * plain["duration"]
        plain["protocol"] = [first, {"time": middle}, {"time": middle, "strain": 0.1 * strain}]
    if plain["hydrodynamics"]["drag"] == "stokes" and dice.random() < 0.2:
        plain["gravity"] = 9.81
        plain["liquid"]["density"] = 1000.0
        for one in plain["particles"]:
            one["density"] = min(1000.0 + 1e-4 * modulus / 9.81 / radius, 9e4)


def walls(dice, plain, sizes, course):
    """A cell between a bottom and a top that moves or yields."""
    radius, modulus, dimensions = sizes
    rate, _ = course
    cell(dice, plain, sizes, course)
    plain["protocol"] = []
    stress = modulus * float(10.0 ** dice.uniform(-5, -3)) * (radius if dimensions == 2 else 1.0)
    bottom, top = {"side": "bottom"}, {"side": "top"}
    drive = str(dice.choice(["glide", "press", "pull", "still"]))
    if drive == "glide":
        top["velocity"] = [rate * 6.0 * radius, 0.0, 0.0][:dimensions]
    if drive in ("press", "pull"):
        top["pressure"] = stress
    if drive == "pull":
        top["shear_stress"] = 0.3 * stress
    if dice.random() < 0.3:
        bottom["modulus"] = modulus
    plain["walls"] = [bottom, top]


def drawn(dice):
    """The tables of a scene with more spheres, and with up to three further options."""
    plain = draw(dice)
    if "cell" in plain and dice.random() < 0.7:
        more = int(dice.integers(2, 9 if len(plain["cell"]["size"]) == 2 else 6))
        for one in plain["particles"]:
            one["count"] *= more
    for place in sorted(dice.permutation(len(OPTIONS))[: int(dice.integers(0, 4))]):
        OPTIONS[place](dice, plain)
    return plain


def scales(plain):
    """A radius, a modulus and the number of dimensions of a scene."""
    one = plain["particles"][0]
    radius = one["radius"]["mean"] if isinstance(one["radius"], dict) else one["radius"]
    given = plain["cell"]["size"] if "cell" in plain else one["positions"][0]
    return radius, one["modulus"], len(given)


def add_name_of_liquid(dice, plain):
    """A named liquid with a viscosity of its own."""
    plain["liquid"] |= {"name": "water", "temperature": float(dice.uniform(280.0, 350.0))}


def add_prefactors(dice, plain):
    """Prefactors in place of those of the set."""
    for name in ("squeeze", "shear", "normal", "tangential", "gap_weight", "deflection_weight"):
        if dice.random() < 0.5:
            plain["films"][name] = float(np.exp(dice.uniform(-1.0, 1.5)))


def add_drops(dice, plain):
    """Drops of any viscosity."""
    plain["films"] |= {"interface": "drop", "viscosity_ratio": float(10.0 ** dice.uniform(-3, 3))}


def add_list_of_radii(dice, plain):
    """One radius per sphere, or a histogram."""
    if "cell" in plain:
        radius, _, _ = scales(plain)
        one = plain["particles"][0]
        radii = (radius * dice.uniform(0.8, 1.2, one["count"])).tolist()
        listed = dice.random() < 0.5
        one["radius"] = radii if listed else {"distribution": "histogram", "radii": radii[:3]}
        if not listed:
            one["radius"]["weights"] = [1.0, 2.0, 3.0][: len(radii[:3])]


def add_share(dice, plain):
    """A species by its part of the volume."""
    if len(plain["particles"]) > 1 and "count" in plain["particles"][1] and scales(plain)[0] == plain_radius(plain, 0):
        del plain["particles"][1]["count"]
        plain["particles"][1]["volume_share"] = float(dice.uniform(0.2, 0.6))


def plain_radius(plain, place):
    """The radius of a species where it is one number."""
    radius = plain["particles"][place]["radius"]
    return radius if isinstance(radius, float) else None


def add_wide_gaps(dice, plain):
    """Larger gaps at the start, and films across them."""
    if "cell" in plain:
        radius, _, _ = scales_of_lists(plain)
        plain["cell"]["minimum_gap"] = radius * float(10.0 ** dice.uniform(-4, -1.3))
        plain["films"]["cutoff"] = radius * float(dice.uniform(0.3, 1.0))


def scales_of_lists(plain):
    """The scales of a scene whose radii are given in any way."""
    one = plain["particles"][0]
    given = one["radius"]
    if isinstance(given, list):
        given = float(np.mean(given))
    if isinstance(given, dict):
        given = given.get("mean") or float(np.mean(given["radii"]))
    return scales(plain | {"particles": [one | {"radius": given}]})


def add_glued(dice, plain):
    """Rough walls."""
    if plain.get("walls") and "cell" in plain:
        plain["hydrodynamics"] = {"drag": "none"}
        radius, modulus, dimensions = scales_of_lists(plain)
        count = int(dice.integers(2, 6)) * (dimensions - 1)
        for side in ["bottom", "top"][: 1 + int(dice.random() < 0.6)]:
            plain["particles"].append({"radius": radius, "modulus": modulus, "count": count, "glued": side})
            if "gravity" in plain:
                plain["particles"][-1]["density"] = plain["particles"][0]["density"]
        plain["particles"][0] = one = dict(plain["particles"][0])
        if not isinstance(one["radius"], list):
            one["count"] = one["count"] + 3 * count


def add_preparation(dice, plain):
    """A packing that is compressed before time 0."""
    if "cell" not in plain:
        return
    radius, modulus, dimensions = scales_of_lists(plain)
    pressure = modulus * float(10.0 ** dice.uniform(-4.5, -3)) * (radius if dimensions == 2 else 1.0)
    spec = {"pressure": pressure, "relaxed": float(dice.choice([0.3, 0.1, 0.03]))}
    if not plain.get("walls") and dice.random() < 0.5:
        spec = {"volume_fraction": 0.85 if dimensions == 2 else 0.62, "relaxed": 0.1}
        plain["cell"]["volume_fraction"] = min(plain["cell"]["volume_fraction"], 0.75 if dimensions == 2 else 0.5)
    if plain.get("walls"):
        plain["walls"][1].pop("velocity", None)
        plain["walls"][1]["pressure"] = pressure
    else:
        for row in plain["protocol"]:
            row.pop("scale", None)
    spec["rate"] = float(10.0 ** dice.uniform(-6, -4.5)) * modulus / plain["liquid"]["viscosity"]
    plain["preparation"] = spec


def add_permeation(dice, plain):
    """Liquid that permeates the packing between two walls."""
    if not plain.get("walls") or "cell" not in plain:
        return
    radius, _, _ = scales_of_lists(plain)
    drained = [True, bool(dice.random() < 0.5)]
    for wall, flows in zip(plain["walls"], [drained[k] for k in dice.permutation(2)], strict=False):
        wall["drained"] = flows
    plain["permeation"] = {"layer_height": radius * float(dice.uniform(1.5, 5.0))}
    if dice.random() < 0.3:
        plain["permeation"] |= {"law": "constant", "permeability": radius**2 * float(10.0 ** dice.uniform(-5, -1))}
    plain["hydrodynamics"] = {"drag": "none"}


def add_stages(dice, plain):
    """A stress or a rate that changes, or an oscillation of a stress, in the middle between two frames."""
    middle = 0.6 * plain["duration"]
    if plain.get("walls") or "cell" not in plain:
        loads = [1.0, float(dice.choice([1.0, 1.5]))]
        plain["protocol"] = [
            {"time": 0.0, "load": 0.5},
            *({"time": middle, "load": load} for load in loads),
        ]
        if any("shear_stress" in wall for wall in plain.get("walls", [])) and dice.random() < 0.5:
            plain["protocol"][1]["wall_shear"] = 2.0
        return
    first = plain["protocol"][0]
    if "shear_stress" in first:
        if dice.random() < 0.5:
            first["oscillation"] = {"frequency": 2.0 / plain["duration"], "stress": 0.3 * first["shear_stress"]}
        else:
            plain["protocol"] = [first, {"time": middle, "shear_stress": -0.5 * first["shear_stress"]}]
    elif "shear_rate" in first:
        rest = {"shear_rate": 0.0} if dice.random() < 0.5 else {"shear_stress": 0.0}
        plain["protocol"] = [first, {"time": middle, **rest}]


def add_sides(dice, plain):
    """A box that is closed along another axis, too; most of them are filled by gravity."""
    if "cell" not in plain or "preparation" in plain or "permeation" in plain:
        return
    dimensions = scales_of_lists(plain)[2]
    sides = [("left", "right"), ("front", "back")][int(dice.random() < 0.5) if dimensions == 3 else 0]
    if not plain.get("walls"):
        plain["protocol"], plain["walls"] = [], [{"side": "bottom"}]
        plain["cell"]["volume_fraction"] *= 0.7
    if sides[0] == "left":
        for wall in plain["walls"]:
            wall.pop("shear_stress", None)
            wall.pop("velocity", None)
    plain["walls"] += [{"side": side} for side in sides]
    if dice.random() < 0.7:
        add_weight(dice, plain)


def add_weight(dice, plain):
    """Gravity along an axis, or oblique."""
    radius, modulus, dimensions = scales_of_lists(plain) if "cell" in plain else scales(plain)
    held = plain["hydrodynamics"]["drag"] == "stokes" or plain.get("walls")
    if not held:
        return
    tilt = float(dice.choice([0.0, 0.3])) if plain["hydrodynamics"]["drag"] == "stokes" else 0.0
    plain["gravity"] = [9.81 * math.sin(tilt), -9.81 * math.cos(tilt), 0.0][:dimensions]
    plain["liquid"]["density"] = 1000.0
    for one in plain["particles"]:
        one["density"] = min(1000.0 + 1e-4 * modulus / 9.81 / radius, 9e4) * (1.0 if dice.random() < 0.8 else 0.5)


def add_driven_species(dice, plain):
    """A force and a torque on one species of a cell: it moves through the other."""
    if "cell" not in plain or plain["hydrodynamics"]["drag"] != "stokes":
        return
    radius, modulus, dimensions = scales_of_lists(plain)
    one = plain["particles"][0]
    strength = modulus * radius**2 * float(10.0 ** dice.uniform(-6, -4))
    one["force"] = (strength * dice.normal(size=dimensions)).tolist()
    if plain["rotation"]:
        one["torque"] = (0.3 * strength * radius * dice.normal(size=1 if dimensions == 2 else 3)).tolist()


def add_squeezing(dice, plain):
    """A cluster between two walls that approach it or shear it."""
    if "cell" in plain or plain.get("walls") or plain["hydrodynamics"]["drag"] == "none":
        return
    radius = max(one["radius"] for one in plain["particles"])
    heights = [place[1] for one in plain["particles"] for place in one["positions"]]
    low, high = min(heights) - 1.1 * radius, max(heights) + 1.1 * radius
    speed = 0.05 * radius / plain["duration"]
    dimensions = len(plain["particles"][0]["positions"][0])
    along = [[0.0, -speed, 0.0], [3.0 * speed, 0.0, 0.0]][int(dice.random() < 0.5)][:dimensions]
    plain["walls"] = [{"side": "bottom", "position": low}, {"side": "top", "position": high, "velocity": along}]


OPTIONS = (
    add_name_of_liquid, add_prefactors, add_drops, add_share, add_list_of_radii, add_wide_gaps, add_preparation,
    add_permeation, add_glued, add_stages, add_sides, add_weight, add_driven_species, add_squeezing,
)  # fmt: skip
"""In the order in which they are added."""


def explicit(scene):
    """The scene with all positions and radii given. Raises SceneError."""
    plain, first = to_plain(scene), 0
    preparation = plain.pop("preparation", None)
    if preparation is not None:
        scene = from_plain(plain)
    parameters = SOFT.parameters(scene)
    if preparation is None:
        SOFT.start(scene, parameters)
    position = places(scene, parameters)
    for one in plain["particles"]:
        count = one.pop("count", None) or len(one["positions"])
        for key in ("sizes", "radii", "volume_share"):
            one.pop(key, None)
        last = first + count
        one["radius"], one["positions"] = parameters.radius[first:last].tolist(), position[first:last].tolist()
        first = last
    if scene.cell is not None:
        plain["cell"] = {"size": list(sides_of(scene))}
    return plain if preparation is None else plain | {"preparation": preparation}


def reordered(plain, dice):
    """The spheres of each species, and the species, in another order; and the order."""
    counts = [len(one["positions"]) for one in plain["particles"]]
    ends = np.cumsum([0, *counts])
    kinds = dice.permutation(len(counts))
    order, particles = [], []
    for kind in kinds:
        one, mixed = plain["particles"][kind], dice.permutation(counts[kind])
        particles.append(
            one | {"positions": [one["positions"][k] for k in mixed], "radius": [one["radius"][k] for k in mixed]}
        )
        order += [int(ends[kind] + k) for k in mixed]
    return plain | {"particles": particles}, np.array(order)


OPPOSITE = {"left": "right", "right": "left", "bottom": "top", "top": "bottom", "front": "front", "back": "back"}


def turned(plain, dice, dimensions):
    """The scene rotated: by any angle without a cell and walls, else by half a turn about z; and the matrix."""
    free = not (plain.get("cell") or plain.get("walls") or plain.get("gravity"))
    turn = Rotation.random(random_state=int(dice.integers(2**31))) if free else Rotation.from_euler("z", math.pi)
    if dimensions == 2 and free:
        turn = Rotation.from_euler("z", float(dice.uniform(0.3, 3.0)))
    matrix = turn.as_matrix()[:dimensions, :dimensions]
    if not free:
        matrix = np.round(matrix)
    shift = np.zeros(dimensions)
    if plain.get("cell"):
        shift[:2] = plain["cell"]["size"][:2]
    found = dict(plain)
    found["particles"] = [_turned_species(one, turn, matrix, shift) for one in plain["particles"]]
    if plain.get("gravity"):
        found["gravity"] = (matrix @ np.array(plain["gravity"])).tolist()
    if plain.get("walls"):
        found["walls"] = [_turned_wall(wall, matrix, shift) for wall in plain["walls"]]
    return found, matrix


def _turned_species(one, turn, matrix, shift):
    new = dict(one)
    new["positions"] = [(matrix @ np.array(place) + shift).tolist() for place in one["positions"]]
    if one.get("force") is not None:
        new["force"] = (matrix @ np.array(one["force"])).tolist()
    if one.get("glued") is not None:
        new["glued"] = OPPOSITE[one["glued"]]
    if one.get("torque") is not None and len(one["torque"]) == 3:
        new["torque"] = turn.apply(one["torque"]).tolist()
    return new


def _turned_wall(wall, matrix, shift):
    new = dict(wall, side=OPPOSITE[wall["side"]])
    axis = SIDES[wall["side"]][0]
    if wall.get("position") is not None:
        new["position"] = float(matrix[axis, axis] * wall["position"] + shift[axis])
    if wall.get("velocity") is not None:
        new["velocity"] = (matrix @ np.array(wall["velocity"])).tolist()
    if wall.get("shear_stress") is not None:
        new["shear_stress"] = -wall["shear_stress"]
    return new


class Slow(Exception):
    """More steps than a test may take."""


def copied(state):
    """A copy of a state that later steps do not change."""
    return state._replace(**{name: value.copy() for name, value in state._asdict().items() if hasattr(value, "copy")})


def run(scene, state=None, keep=(), limit=math.inf):
    """The frames of a scene, and copies of the state at the given frames. Raises Slow after `limit` s of processor."""
    frames, states = [], {}
    with at_most(limit, lambda: f"stopped after frame {len(frames)} of {scene.frames + 1}"):
        for moment in moments(scene, state=state):
            if moment.frame is not None:
                if len(frames) in keep:
                    states[len(frames)] = copied(moment.state)
                frames.append(moment.frame)
            if moment.taken > MOST_STEPS:
                raise Slow(f"stopped at {frames[-1].time / scene.duration:.0%} after {moment.taken} steps")
    return frames, states


@contextlib.contextmanager
def at_most(limit, reason):
    """Raise Slow after `limit` s of processor, also within a preparation, which has no moments."""

    def stop(number, frame):
        raise Slow(reason())

    if not math.isfinite(limit):
        yield
        return
    before = signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, limit)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)


def faults(scene, frames):
    """The violated conditions of a run: balance of forces, imposed stresses, symmetry, and energy budget."""
    found = {}
    first, last = frames[0].numbers, frames[-1].numbers
    worst = max(frame.numbers["imbalance"] for frame in frames)
    if not worst < 1e-6:
        found["balance"] = worst
    if not all(np.isfinite(value).all() for frame in frames for value in (frame.arrays["position"],)):
        found["finite"] = math.nan
    for name in ("shear_stress", "normal_stress", "pressure"):
        missing = missed_stress(scene, frames, name)
        if not missing < 1e-6:
            found[name] = missing
    if scene.cell is not None and not scene.walls and scene.rotation and scene.hydrodynamics.drag == "none":
        for frame in frames:
            tensor = stress_tensor(frame)
            scale = max(float(np.abs(tensor).max()), LEAN * rounding_of(scene)["pressure"])
            lean = float(np.abs(tensor - tensor.T).max()) / scale
            if lean > 1e-6:
                found["symmetry"] = lean
    spent = last["dissipated_work"] + last.get("size_work", 0.0) + last["total_energy"] - first["total_energy"]
    moved = abs(last["dissipated_work"]) + abs(last["total_energy"]) + abs(last["contact_work"])
    missing = abs(last["injected_work"] - spent) / max(moved, rounding_of(scene)["total_energy"])
    if not missing < error_of_scene(scene):
        found["power"] = missing
    return found


def imposed(scene, name, time):
    """The stress of that name that the protocol of a cell imposes at a time; None where it follows."""
    others, value, wave = next(group for group in EXCLUSIVE if name in group), None, None
    for stage in scene.protocol if scene.cell is not None and not scene.walls else ():
        if stage.time > time:
            break
        wave = (stage.oscillation, stage.time) if stage.oscillation is not None else None
        if any(getattr(stage, other) is not None for other in others):
            value = getattr(stage, name)
    if value is not None and wave and name == "shear_stress":
        spec, began = wave
        value += spec.stress * math.sin(2.0 * math.pi * spec.frequency * (time - began))
    return value


def missed_stress(scene, frames, name):
    """The largest error of an imposed stress, over the largest that is imposed, or over what rounding is 1e-6 of."""
    wanted = [(imposed(scene, name, frame.time), frame.numbers.get(name)) for frame in frames]
    pairs = [(value, got) for value, got in wanted if value is not None]
    scale = max((abs(value) for value, _ in pairs), default=0.0) or 1e6 * rounding_of(scene)["pressure"]
    return max((abs(got - value) / scale for value, got in pairs), default=0.0)


SHARED = ("dissipated_work", "total_energy", "smallest_gap", "largest_compression", "shear_stress", "pressure")
"""Numbers of a frame that depend neither on the order of spheres nor on the direction of the axes."""


def rounding_of(scene):
    """The effect of rounding of positions on each number; for forces, that of the stiffest springs, those of glue."""
    radius = max(one.radius for one in scene.particles)
    force = ROUNDED * max(one.modulus for one in scene.particles) * radius**2
    stiffest = force * (GLUE if any(one.glued for one in scene.particles) else 1.0)
    stress = stiffest / radius ** (dimensions_of(scene) - 1)
    return {
        "dissipated_work": force * radius, "total_energy": force * radius, "smallest_gap": 1e-12 * radius,
        "largest_compression": stiffest, "shear_stress": stress, "pressure": stress,
    }  # fmt: skip


def error_of_scene(scene):
    """The error of stresses and work that corresponds to the tolerance of a scene."""
    return error_of_run(scene.integration.integrator, scene.integration.tolerance)


def unlike(scene, ours, theirs, matrix=None, order=None):
    """The largest relative difference of two runs: of their numbers in all frames and, without a cell, of displacements
    over the radius.
    """
    found, rounding = 0.0, rounding_of(scene)
    moved = max(abs(ours[-1].numbers[name]) for name in ("dissipated_work", "total_energy", "injected_work"))
    for name in SHARED:
        one, two = (np.array([frame.numbers.get(name, 0.0) for frame in frames]) for frames in (ours, theirs))
        scale = max(np.abs(one).max(), rounding[name], moved if name.endswith(("work", "energy")) else 0.0)
        found = max(found, float(np.abs(one - two).max() / scale))
    if scene.cell is not None:
        return found
    start, end = (frame.arrays["position"] for frame in (ours[0], ours[-1]))
    moved, others = end - start, theirs[-1].arrays["position"] - theirs[0].arrays["position"]
    moved = moved if order is None else moved[order]
    moved = moved if matrix is None else moved @ matrix.T
    if scene.hydrodynamics.drag == "none" and not scene.walls:
        moved, others = moved - moved.mean(axis=0), others - others.mean(axis=0)
    return max(found, float(np.abs(moved - others).max()) / max(one.radius for one in scene.particles))


def sensitive(scene, plain, frames, limit=math.inf):
    """Whether a run differs as much where only the last digits of positions do: then rounding decides, not the order
    of spheres or the axes.
    """
    dice, moved = np.random.default_rng(1), []
    for one in plain["particles"]:
        place = np.array(one["positions"])
        moved.append(one | {"positions": (place * (1.0 + 1e-14 * dice.normal(size=place.shape))).tolist()})
    try:
        again = run(from_plain(plain | {"particles": moved}), limit=limit)[0]
    except (Slow, EcumeError):
        return True
    return not unlike(scene, frames, again) < 2.0 * error_of_scene(scene)


def outcome(seed, drawing=draw, limit=math.inf):
    """The outcome of the run of a random scene, and its violated conditions: a word, and a table."""
    dice = np.random.default_rng(seed)
    plain = drawing(dice)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            with at_most(limit, lambda: "stopped in its start"):
                plain = explicit(from_plain(plain))
            scene = from_plain(plain)
        except Slow as error:
            return "slow", {"reason": str(error)}
        except SceneError as error:
            return "refused", {"reason": str(error)}
        try:
            frames, states = run(scene, keep=(2,), limit=limit)
        except Slow as error:
            return "slow", {"reason": str(error)}
        except (Diverged, EcumeError) as error:
            return "ended", {"reason": str(error)}
        found = faults(scene, frames)
        dimensions = dimensions_of(scene)
        for name, change in (("order", reordered), ("rotation", turned)):
            changed, how = change(plain, dice) if name == "order" else change(plain, dice, dimensions)
            try:
                again = run(from_plain(changed), limit=PATIENCE * limit)[0]
            except (Slow, EcumeError) as error:
                found[name] = str(error) or "slow"
                continue
            more = {"order": how} if name == "order" else {"matrix": how}
            difference = unlike(scene, frames, again, **more)
            # Steps judge the components of directions, and rounding decides which fail: each run errs by its tolerance.
            if not difference < 2.0 * error_of_scene(scene):
                found[name] = difference
        if ("order" in found or "rotation" in found) and sensitive(scene, plain, frames, PATIENCE * limit):
            found = {"sensitive" if name in ("order", "rotation") else name: value for name, value in found.items()}
        if states:
            resumed = run(scene, state=states[2])[0]
            same = all(np.array_equal(resumed[-1].arrays[key], frames[-1].arrays[key], equal_nan=True)
                       for key in frames[-1].arrays)  # fmt: skip
            if not same or resumed[-1].numbers != frames[-1].numbers:
                found["restart"] = 1.0
    return "done", found


def main(first, last, limit):
    """Print how the scene of each seed of a range ends, and how many ended so, by kind."""
    counts = Counter()
    for seed in range(first, last):
        began = time.process_time()
        try:
            word, found = outcome(seed, drawn, limit)
        except Exception:  # a fault of the model, or of these tests
            word, found = "traceback", {"reason": traceback.format_exc(limit=-3)}
        counts[word] += 1
        for name in found:
            counts[f"{word}: {name}"] += 1
        print(seed, word, found, f"{time.process_time() - began:.1f} s", flush=True)
    print(dict(counts), flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]), float(sys.argv[3]))
