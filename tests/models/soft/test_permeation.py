"""Permeation: Darcy's law in layers, consolidation, undrained walls, and random scenes."""

import math

import numpy as np
import pytest

from ecume.errors import SceneError
from ecume.laws.permeability import (
    consolidation_coefficient,
    degree_of_consolidation,
    excess_pressure,
    kozeny_carman,
)
from ecume.models.soft import SOFT
from ecume.models.soft.permeation import part_below
from ecume.models.soft.state import workspace
from ecume.scenes.schema import from_plain
from ecume.simulation import moments
from tests.models.soft import random_scenes

RADIUS, MODULUS, VISCOSITY, LOAD, MORE = 1e-3, 1e4, 1.0, 1.0, 0.01
WIDTH = 2.5 * RADIUS
GAP = 1e-6 * RADIUS
"""So thin that films do not drain while the layer consolidates."""


def column(rows=6, dimensions=2, drained=(False, True), **more):
    """Spheres on top of each other under a constant load, which then increases by a hundredth."""
    spacing, depth = 2.0 * RADIUS + GAP, 2.0 * RADIUS if dimensions == 2 else 1.0
    places = [[0.5 * WIDTH, (row + 0.5) * spacing, 0.5 * WIDTH][:dimensions] for row in range(rows)]
    plain = {
        "model": "soft", "duration": 10.0, "frame_every": 2.0, "liquid": {"viscosity": VISCOSITY},
        "particles": [{"radius": RADIUS, "modulus": MODULUS, "positions": places}],
        "cell": {"size": [WIDTH, rows * spacing, WIDTH][:dimensions]}, "films": {"cutoff": 0.2 * RADIUS},
        "walls": [{"side": "bottom", "drained": drained[0]},
                  {"side": "top", "drained": drained[1], "pressure": LOAD * depth}],
        "permeation": {"layer_height": spacing},
        "protocol": [{"time": 0.0}, {"time": 2.0, "load": 1.0}, {"time": 2.0, "load": 1.0 + MORE}],
        "integration": {"integrator": "tr-bdf2", "tolerance": 1e-4},
    }  # fmt: skip
    return from_plain(plain | more)


def consolidation(height, rows, dimensions=2):
    """The coefficient of a column that bears its load, and its last settlement: contacts in series, by Hertz's law."""
    area = WIDTH * (2.0 * RADIUS if dimensions == 2 else WIDTH)
    force, spacing = LOAD * area, height / rows
    overlap = 2.0 * RADIUS + GAP - spacing
    stiffness = force / overlap * (1.0 + 0.5 * overlap / (overlap + GAP))
    permeability = kozeny_carman(4.0 / 3.0 * math.pi * RADIUS**3 / (area * spacing), 2.0 * RADIUS)
    coefficient = consolidation_coefficient(permeability, stiffness * spacing / area, VISCOSITY)
    return coefficient, MORE * force / stiffness * rows


def ran(scene):
    """The frames, and the states at their times."""
    found = [(m.frame, random_scenes.copied(m.state)) for m in moments(scene) if m.frame is not None]
    return [frame for frame, _ in found], [state for _, state in found]


@pytest.mark.long
@pytest.mark.parametrize(
    ("rows", "dimensions", "drained"),
    [
        (6, 2, (False, True)),
        (6, 2, (True, False)),
        # The same loops over more numbers, which take long as plain Python.
        pytest.param(6, 3, (False, True), marks=pytest.mark.compiled),
        pytest.param(12, 2, (True, True), marks=pytest.mark.compiled),
    ],
)
def test_a_column_consolidates_by_terzaghis_series(rows, dimensions, drained):
    """Coefficient and settlement are computed, not fitted. Six rows and secants instead of tangents: one percent. With
    both sides drained each half drains by itself.
    """
    frames, states = ran(column(rows, dimensions, drained))
    height = frames[0].numbers["top_y"]
    coefficient, last = consolidation(height, rows, dimensions)
    path = height if drained != (True, True) else 0.5 * height
    for frame, state in zip(frames[2:], states[2:], strict=True):
        time = frame.time - 2.0
        settled = (height - frame.numbers["top_y"]) / last
        assert settled == pytest.approx(degree_of_consolidation(path, time, coefficient), rel=1e-2, abs=0.0)
        pore = np.abs(np.append(0.0, np.cumsum(state.layer_force))).max() / MORE
        area = WIDTH * (2.0 * RADIUS if dimensions == 2 else WIDTH)
        expected = excess_pressure(path, path, time, coefficient)
        assert pore / (LOAD * area) == pytest.approx(expected, rel=2e-2, abs=0.0)
    numbers = frames[2].numbers
    for side, passes in zip(("bottom", "top"), drained, strict=True):
        assert (numbers[f"pore_pressure_{side}"] > 1e-9 * numbers["largest_pore_pressure"] > 0.0) == (not passes)


@pytest.mark.long
def test_the_liquid_bears_a_new_load_alone():
    """At the time of the step spheres cannot approach: the undrained wall rests on the liquid."""
    frames, _ = ran(column(drained=(True, False)))
    before, after = frames[0].numbers, frames[1].numbers
    assert after["top_force_y"] == pytest.approx(before["top_force_y"], rel=1e-5, abs=0.0)
    assert after["pore_pressure_top"] == pytest.approx(MORE * LOAD * 2.0 * RADIUS, rel=1e-6, abs=0.0)
    assert frames[0].numbers["largest_pore_pressure"] == 0.0


def test_the_parts_of_a_sphere_are_those_of_its_volume():
    """Against the integral of its cross-sections."""
    radius, height = 1.3, 0.4
    z = np.linspace(-radius, height, 200_001)
    volume = np.trapezoid(math.pi * (radius**2 - z**2), z)
    assert part_below(height, radius) == pytest.approx(volume / (4.0 / 3.0 * math.pi * radius**3), rel=1e-8, abs=0.0)


def test_shares_are_weights_of_a_mean_and_layers_contain_all_spheres():
    scene = column()
    parameters = SOFT.parameters(scene)
    state = SOFT.start(scene, parameters)
    from ecume.models.soft.integration.linear_solvers import begin_step
    from ecume.models.soft.protocol import drive_at

    step = workspace(parameters, state, 1.0).step
    begin_step(parameters, step, drive_at(parameters.protocol, 0.0))
    layers = step.permeation
    np.testing.assert_allclose(layers.share.sum(axis=0), 1.0, rtol=1e-12)
    height = (state.wall[1, 1] - state.wall[0, 1]) / len(layers.force)
    solid = float((layers.fraction * layers.medium.area * height).sum())
    assert solid == pytest.approx(float(layers.medium.volume.sum()), rel=1e-12, abs=0.0)


REFUSED = {
    "walls": ({"walls": [{"side": "bottom"}, {"side": "top"}]}, "is across walls"),
    "one of two": ({"walls": [{"side": "bottom", "drained": True}, {"side": "top"}]}, "is missing; the wall across"),
    "closed": (
        {"walls": [{"side": "bottom", "drained": False}, {"side": "top", "drained": False, "pressure": 1.0}]},
        "keep their volume; expected one that is drained",
    ),
    "closing": (
        {"walls": [{"side": "bottom", "drained": False}, {"side": "top", "drained": False, "velocity": [0.0, -1.0]}]},
        "keep their volume",
    ),
    "drag": ({"hydrodynamics": {"drag": "stokes"}}, "both are the drag of the liquid"),
    "two axes": (
        {"walls": [{"side": "bottom", "drained": True}, {"side": "top", "drained": True},
                   {"side": "left", "drained": True}]},
        "across another axis",
    ),
    "narrowing": (
        {"walls": [{"side": "bottom", "drained": True}, {"side": "top", "drained": True},
                   {"side": "left", "velocity": [1.0, 0.0]}]},
        "changes the cross-section",
    ),
    "no table": ({"permeation": None}, r"with \[permeation\]; add that table"),
}  # fmt: skip


@pytest.mark.parametrize("name", REFUSED)
def test_what_no_liquid_can_permeate_is_refused_with_the_reason(name):
    change, reason = REFUSED[name]
    with pytest.raises(SceneError, match=reason):
        column(**change)


@pytest.mark.parametrize(
    ("given", "reason"),
    [
        ({"law": "constant"}, "permeability: is missing"),
        ({"permeability": 1e-9}, "permeability: kozeny-carman computes it"),
        ({"law": "kozeny"}, "kozeny"),
    ],
)
def test_a_permeability_is_given_or_computed(given, reason):
    with pytest.raises(SceneError, match=reason):
        SOFT.parameters(column(permeation=given))


def permeating(dice):
    """A random packing between walls that liquid permeates."""
    plain = random_scenes.draw(dice)
    while "walls" not in plain or "cell" not in plain:
        plain = random_scenes.draw(dice)
    drained = [bool(dice.random() < 0.5) for _ in range(2)]
    top = plain["walls"][1]
    if "pressure" in top and not any(drained):
        drained[int(dice.integers(2))] = True
    for wall, open_ in zip(plain["walls"], drained, strict=True):
        wall["drained"] = open_
    radius = plain["particles"][0]["radius"]
    mean = radius if isinstance(radius, float) else radius["mean"]
    plain["permeation"] = {"layer_height": mean * float(dice.uniform(1.5, 5.0))}
    if dice.random() < 0.3:
        plain["permeation"] |= {"law": "constant", "permeability": mean**2 * float(10.0 ** dice.uniform(-5, -1))}
    plain["hydrodynamics"] = {"drag": "none"}
    plain["cell"]["volume_fraction"] = float(dice.uniform(0.4, 0.65)) * (
        1.0 if len(plain["cell"]["size"]) == 2 else 0.7
    )
    plain["films"]["cutoff"] = mean * float(dice.uniform(0.6, 1.0))
    plain["cell"]["minimum_gap"] = 0.02 * mean
    plain.pop("gravity", None)
    if top.get("pressure") and dice.random() < 0.5:
        middle = 0.4 * plain["duration"]
        plain["protocol"] = [{"time": 0.0}, {"time": middle, "load": 1.0}, {"time": middle, "load": 1.3}]
    return plain


@pytest.mark.long
@pytest.mark.compiled
@pytest.mark.parametrize("seed", [1, 5, 11])
def test_a_random_packing_that_liquid_permeates_keeps_what_every_run_keeps(seed):
    """Balance, energy, the order of spheres, half a turn of the scene, and half runs."""
    assert random_scenes.outcome(seed, permeating) == ("done", {})


def compressed(dice):
    """The same after a preparation, during which no liquid has to permeate, by the wall that has a pressure."""
    plain = permeating(dice)
    while "pressure" not in plain["walls"][1]:
        plain = permeating(dice)
    pressure, rate = (
        plain["walls"][1]["pressure"],
        1e-5 * plain["particles"][0]["modulus"] / plain["liquid"]["viscosity"],
    )
    return plain | {
        "preparation": {"pressure": float(dice.choice([0.5, 1.0])) * pressure, "rate": rate, "relaxed": 0.1}
    }


@pytest.mark.long
@pytest.mark.compiled
@pytest.mark.parametrize("seed", [1])
def test_a_random_packing_that_is_prepared_and_then_permeated_keeps_what_every_run_keeps(seed):
    assert random_scenes.outcome(seed, compressed) == ("done", {})


def test_liquid_permeates_a_prepared_packing_from_time_zero_on():
    """The compression leaves no pore pressure; a load that grows then is borne by the liquid alone."""
    prepared = {"preparation": {"pressure": LOAD * 2.0 * RADIUS, "rate": 0.3, "relaxed": 0.3}}
    scene = column(3, duration=2.0, **prepared)
    frames, _ = ran(scene)
    first, last = frames[0].numbers, frames[1].numbers
    assert first["preparation_time"] > 0.0
    assert first["largest_pore_pressure"] == 0.0
    assert last["pore_pressure_bottom"] == pytest.approx(MORE * LOAD * 2.0 * RADIUS, rel=0.05, abs=0.0)
