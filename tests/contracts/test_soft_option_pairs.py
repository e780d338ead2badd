"""Each option of soft spheres with each other one: a few steps in a small cell, or a physical reason against it.

The matrix in `docs/physics/soft.md` is written by `python -m tests.contracts.test_soft_option_pairs`.
"""

import copy

import pytest
from tests.contracts.option_pairs import Pairs, frames_of, matrix, merged, section, write_section
from tests.models.soft.test_threads import threaded_loops


def push(gap, parameters):
    """A repulsion (N) that decays with the gap."""
    return parameters.constants[0] / gap


LAWS = [push]

PLACES = [(0.0, 1.05), (2.05, 1.07), (1.0, 2.86), (3.05, 2.88)]
SIZES = [(1.0, 1.0), (0.98, 1.3)]
"""Radius and modulus of the two species."""
PULLS = [(2.05e-3, 2e-5), (-2.05e-3, -2e-5)]
"""On the spheres of each species (N): nothing is left of their sum, nor of its moment."""
BOX = {"cell": {"size": [4.1, 3.93]}}
WALLS = {"walls": [{"side": "bottom"}, {"side": "top"}], **BOX}
RUN = {"time": 0.0}


def stage(**given):
    """A protocol with these values at the beginning."""
    return {**BOX, "protocol": [{**RUN, **given}]}


def until(**given):
    """A protocol with these values at the end."""
    return {**BOX, "protocol": [RUN, {"time": 0.2, **given}]}


OPTIONS = {
    "surface bubble": {"films": {"surface": "bubble"}},
    "interface half-mobile": {"films": {"interface": "half-mobile"}},
    "interface mobile": {"films": {"interface": "mobile"}},
    "interface drop": {"films": {"interface": "drop", "viscosity_ratio": 0.5}},
    "friction coulomb": {"films": {"friction": "coulomb", "roughness": 0.08}},
    "friction critical-load": {"films": {"friction": "critical-load", "roughness": 0.08, "critical_load": 1e-5}},
    "tangential_law secant": {"films": {"tangential_law": "secant"}},
    "tension_law gap": {"films": {"tension_law": "gap"}},
    "tension_law cavitation": {"films": {"tension_law": "cavitation", "cavitation_pressure": 1e-4}},
    "prefactors physical": {"films": {"prefactors": "physical"}},
    "cutoff": {"films": {"cutoff": 0.4}},
    "long-range steric": {"long_range_forces": {"law": "steric", "steric_strength": 1e-3, "steric_length": 0.08}},
    "long-range dlvo": {
        "long_range_forces": {
            "law": "dlvo",
            "hamaker_constant": 1e-6,
            "double_layer_strength": 1e-4,
            "debye_length": 0.05,
        }
    },
    "user law": {"user_laws": [{"law": "push", "species": ["sphere-1", "sphere-2"], "constants": [1e-6]}]},
    "integrator tr-bdf2": {"integration": {"integrator": "tr-bdf2"}},
    "solver dense": {"integration": {"solver": "dense"}},
    "solver iterative": {"integration": {"solver": "iterative"}},
    "solver direct": {"integration": {"solver": "direct"}},
    "3D": {"dimensions": 3},
    "rotation": {"rotation": True},
    "torque": {"rotation": True, "torque": 1e-4},
    "hydrodynamics.drag": {"hydrodynamics": {"drag": "stokes"}},
    "gravity": {"gravity": -1e-5},
    "cell": BOX,
    "walls": WALLS,
    "walls that move": merged(WALLS, {"walls": [{}, {"velocity": [0.05, 0.0]}]}),
    "walls that yield": merged(WALLS, {"walls": [{}, {"pressure": 2e-3, "shear_stress": 1e-3}]}),
    "walls with a modulus": merged(WALLS, {"walls": [{"modulus": 2.0}, {"modulus": 2.0}]}),
    "rough walls": merged(WALLS, {"glued": "bottom"}),
    "permeation": merged(
        WALLS,
        {"walls": [{"drained": False}, {"drained": True, "pressure": 2e-3}], "permeation": {"layer_height": 2.0}},
    ),
    "load ramp": {"protocol": [{**RUN, "load": 0.0}, {"time": 0.2, "load": 1.0}]},
    "strain": until(strain=0.01),
    "shear_rate": stage(shear_rate=0.05),
    "rate_steps": stage(rate_steps={"rates": [0.05, -0.05], "strain": 0.005}),
    "shear_stress": stage(shear_stress=1e-3),
    "oscillation": stage(oscillation={"frequency": 5.0, "amplitude": 0.002}),
    "scale": until(scale=0.999),
    "height_rate": stage(height_rate=-0.01),
    "normal_stress": stage(normal_stress=1e-3),
    "pressure": stage(pressure=1e-3),
}


def plain_of(one, other):
    """The scene of two options: four spheres close to contact."""
    asked = copy.deepcopy(merged(OPTIONS[one], OPTIONS[other]))
    dimensions, boxed, gravity = asked.pop("dimensions", 2), "cell" in asked, asked.pop("gravity", 0.0)
    torque, glued = asked.pop("torque", 0.0), asked.pop("glued", None)
    deep = dimensions - 2
    spheres = [
        {"radius": radius, "modulus": modulus, "density": 2000.0, "force": [*pull, *[0.0] * deep],
         "positions": [[*place, *[1.05] * deep] for place in PLACES[which::2]]}
        for which, ((radius, modulus), pull) in enumerate(zip(SIZES, PULLS, strict=True))
    ]  # fmt: skip
    for sign, species in zip((1.0, -1.0), spheres, strict=True):
        if torque:
            species["torque"] = [sign * torque] if dimensions == 2 else [0.0, 0.0, sign * torque]
    if glued:
        spheres[0]["glued"] = glued
    if boxed:
        asked["cell"] = {"size": [*BOX["cell"]["size"], *[2.3] * deep]}
    for wall in asked.get("walls", []):
        if "velocity" in wall:
            wall["velocity"] = [*wall["velocity"], *[0.0] * deep]
    base = {
        "model": "soft", "duration": 0.2, "frame_every": 0.1, "particles": spheres,
        "liquid": {"viscosity": 0.1, "surface_tension": 0.3, "density": 1000.0}, "integration": {"tolerance": 1e-5},
    }  # fmt: skip
    return merged(base, asked) | ({"gravity": [0.0, gravity, *[0.0] * deep]} if gravity else {})


PAIRS = Pairs("soft.md", OPTIONS, plain_of, LAWS)


def marks(*options):
    """Walls have contacts of their own, which are compiled by themselves. So would be a user's law with each option:
    as plain Python it takes less, and `test_an_option_has_the_same_bits_in_threads` has it compiled.
    """
    long = [pytest.mark.long] * any("wall" in name or name == "permeation" for name in options)
    return [*long, pytest.mark.uncompiled if "user law" in options else pytest.mark.compiled]


@pytest.mark.sampled(6)
@pytest.mark.parametrize(
    ("one", "other"),
    [pytest.param(*pair, id="-".join(pair), marks=marks(*pair)) for pair in PAIRS.names],
)
def test_a_pair_of_options_works_or_is_refused_for_a_reason(one, other):
    PAIRS.require_works_or_reason(one, other)


def bits(plain):
    """The bits of all frames of a scene, and why it is refused if it is."""
    frames, refusal = frames_of(plain, LAWS)
    return [array.tobytes() for frame in frames for array in frame.arrays.values()], refusal


@pytest.mark.compiled
@pytest.mark.long
@pytest.mark.parametrize("option", [name for name in OPTIONS if not name.startswith(("solver ", "gravity"))])
def test_an_option_has_the_same_bits_in_threads(monkeypatch, option):
    """As in a packing of thousands of spheres, where each loop over contacts is compiled for threads. Gravity alone has
    nothing to hold it.
    """
    plain = plain_of(option, "solver iterative")
    alone = bits(plain)
    assert alone[1] == ""
    for loop in threaded_loops():
        monkeypatch.setattr(loop, "few", 1)
    assert bits(plain) == alone


def test_the_page_has_a_row_and_a_column_for_each_option():
    """What it says of each pair is compared above with what becomes of that."""
    assert section(PAIRS.page) == matrix(OPTIONS, PAIRS.stated)


if __name__ == "__main__":
    write_section(PAIRS.page, PAIRS.matrix())
