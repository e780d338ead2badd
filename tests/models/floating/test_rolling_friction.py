"""Floats that resist being rolled over one another."""

import math
from itertools import pairwise

import numpy as np
import pytest

from ecume.errors import SceneError
from ecume.laws.drag import sphere_inertia
from ecume.laws.friction import holding_rolling_friction
from ecume.models.floating.forces.pair_forces import law_of, row_of, two_floats
from ecume.models.floating.setup.scene_parameters import parameters_of
from ecume.scenes.schema import from_plain
from ecume.simulation import simulate

RADIUS = 1e-3


def chain(bend, *, friction=1.5, rolling=0.0, turned=0.0, mirrored=1.0, duration=0.5, **tables):
    """Three spheres that touch, at rest; the one in the middle sees the others at the angle `bend`."""
    apart = 2.0 * RADIUS * (1.0 + 1e-7)
    ends = [turned + 0.5 * bend, turned - 0.5 * bend]
    places = [[apart * math.cos(end), mirrored * apart * math.sin(end)] for end in ends]
    return from_plain({
        "model": "floating", "duration": duration, "frame_every": 0.5 * duration,
        "liquid": {"density": 1000.0, "viscosity": 0.01, "surface_tension": 0.0728},
        "particles": [{"radius": RADIUS, "density": 1300.0, "contact_angle": math.pi / 2,
                       "positions": [places[0], [0.0, 0.0], places[1]]}],
        "contacts": {"friction": friction, "rolling_friction": rolling},
        "hydrodynamics": {"drag": "stokes"}, **tables,
    })  # fmt: skip


def bend_of(frame):
    """The angle at the sphere in the middle."""
    one, other = (frame.arrays["position"][k] - frame.arrays["position"][1] for k in (0, 2))
    return math.acos(one @ other / math.sqrt((one @ one) * (other @ other)))


def holding(bend):
    """The coefficient at which such a chain holds, from the pair law of the scene."""
    parameters = parameters_of(chain(bend))
    charges = (float(parameters.floats.charge[0]),) * 2
    pair, law = two_floats(parameters, (RADIUS, RADIUS), charges), law_of(parameters)
    pulls = [-float(row_of(parameters).force(apart * RADIUS, pair, law)) for apart in (2.0, 4.0 * math.sin(0.5 * bend))]
    return holding_rolling_friction(bend, *pulls)


@pytest.mark.long
@pytest.mark.parametrize("bend", [1.3, 2.0, 2.8])
def test_a_bent_chain_holds_above_the_coefficient_of_its_lever_and_closes_below(bend):
    *_, below = simulate(chain(bend, rolling=0.99 * holding(bend)))
    *_, above = simulate(chain(bend, rolling=1.01 * holding(bend)))
    assert bend_of(below) < bend - 1e-3 * holding(bend)
    assert bend_of(above) == pytest.approx(bend, abs=1e-7)


@pytest.mark.long
def test_rolling_friction_holds_no_chain_that_slides():
    limit = 0.5 * holding(2.0)
    *_, slides = simulate(chain(2.0, friction=0.97 * limit, rolling=3.0))
    *_, holds = simulate(chain(2.0, friction=1.03 * limit, rolling=3.0))
    assert bend_of(slides) < 1.9
    assert bend_of(holds) == pytest.approx(2.0, abs=1e-7)


@pytest.mark.long
@pytest.mark.compiled
def test_the_ends_of_a_chain_stay_apart_for_a_minute():
    ends = {}
    for rolling in (0.0, 0.4):
        *_, last = simulate(chain(2.0, friction=1.0, rolling=rolling, duration=60.0))
        ends[rolling] = np.linalg.norm(last.arrays["position"][0] - last.arrays["position"][2]) / RADIUS
        assert last.numbers["unconverged_steps"] == 0
    assert ends[0.0] == pytest.approx(2.0, abs=1e-4)
    assert ends[0.4] == pytest.approx(4.0 * math.sin(1.0), abs=1e-4)


def spin_momentum(frame):
    """The angular momentum of floats, spins included."""
    x, v, mass = (frame.arrays[name] for name in ("position", "velocity", "mass"))
    inertia = np.array([sphere_inertia(m, r) for m, r in zip(mass, frame.arrays["radius"], strict=True)])
    return float(np.sum(mass * (x[:, 0] * v[:, 1] - x[:, 1] * v[:, 0]) + inertia * frame.arrays["spin"]))


@pytest.mark.parametrize("seed", range(4))
def test_colliding_floats_gain_no_energy_and_keep_their_angular_momentum(seed):
    dice = np.random.default_rng(seed)
    places = [[2.3e-3 * i, 2.3e-3 * j] for i in range(3) for j in range(2)]
    scene = from_plain({
        "model": "floating", "duration": 0.1, "frame_every": 0.01,
        "particles": [{"radius": [float(r) for r in dice.uniform(0.7e-3, 1e-3, 6)], "density": 1200.0,
                       "contact_angle": 1.5, "positions": places,
                       "velocities": [[float(v) for v in dice.normal(0.0, 0.05, 2)] for _ in places]}],
        "contacts": {"friction": 0.5, "rolling_friction": float(dice.uniform(0.05, 1.0)),
                     "restitution": float(dice.uniform(0.0, 1.0))},
        "interaction": {"law": "none"}, "hydrodynamics": {"drag": "none"},
    })  # fmt: skip
    frames = list(simulate(scene))
    energies = [frame.numbers["kinetic_energy"] for frame in frames]
    assert frames[-1].numbers["collisions"] > 0
    assert np.any(frames[-1].arrays["spin"] != 0.0)
    assert all(after <= before * (1.0 + 1e-12) for before, after in pairwise(energies))
    scale = sum(frames[0].arrays["mass"] * np.linalg.norm(frames[0].arrays["velocity"], axis=1)) * 5e-3
    assert spin_momentum(frames[-1]) == pytest.approx(spin_momentum(frames[0]), abs=1e-12 * scale)


@pytest.mark.long
def test_a_mirrored_chain_closes_as_a_mirror_image():
    one, other = (list(simulate(chain(1.6, rolling=0.2, turned=turned, mirrored=side)))[-1] for turned, side in
                  ((0.3, 1.0), (0.3, -1.0)))  # fmt: skip
    assert bend_of(one) < 1.55
    assert one.arrays["position"] * [1.0, -1.0] == pytest.approx(other.arrays["position"], abs=1e-10)
    assert one.arrays["spin"] == pytest.approx(-other.arrays["spin"], abs=1e-6)


@pytest.mark.parametrize("rolling", [0.0, 0.05])
def test_a_float_that_rolls_along_a_wall_stops_by_rolling_friction(rolling):
    scene = from_plain({
        "model": "floating", "duration": 0.4, "frame_every": 0.2,
        "dish": {"size": [0.2, 0.02], "friction": 0.8, "rolling_friction": rolling, "restitution": 0.0},
        "particles": [{"radius": RADIUS, "density": 300.0, "contact_angle": 1.5,
                       "positions": [[-0.05, -0.01 + RADIUS]], "velocity": [0.02, 0.0]}],
        "hydrodynamics": {"drag": "none"},
    })  # fmt: skip
    *_, last = simulate(scene)
    speed, spin = last.arrays["velocity"][0, 0], last.arrays["spin"][0]
    if rolling:
        assert abs(speed) < 1e-9
        assert abs(spin) * RADIUS < 1e-9
    else:
        # A sphere that slides at first rolls at 5/7 of its speed in the end.
        assert speed == pytest.approx(5.0 / 7.0 * 0.02, rel=1e-6)
        assert abs(spin) * RADIUS == pytest.approx(speed, rel=1e-6)


@pytest.mark.parametrize("table", ["contacts", "dish"])
def test_rolling_friction_without_friction_is_refused(table):
    tables = {"dish": {"radius": 0.05}, "contacts": {}}
    tables[table]["rolling_friction"] = 0.1
    particles = [{"radius": RADIUS, "density": 300.0, "contact_angle": 1.5}]
    with pytest.raises(SceneError, match=rf"{table}.rolling_friction: got 0.1 without friction.*expected friction"):
        from_plain({"model": "floating", "duration": 1.0, "frame_every": 0.1, "particles": particles, **tables})


def test_rolling_friction_with_the_flow_of_neighbors_is_refused():
    with pytest.raises(SceneError, match=r"rolling friction needs .*turns neighbors through the liquid"):
        parameters_of(chain(2.0, rolling=0.1, hydrodynamics={"interaction": "rotne-prager"},
                            integration={"integrator": "overdamped"}))  # fmt: skip
