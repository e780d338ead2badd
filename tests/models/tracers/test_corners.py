"""Brownian tracers where walls meet at any angle, at curved walls and at the edges of obstacles."""

import math

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from ecume.engine.walls import clearance
from ecume.laws import brownian_motion
from ecume.models import MODELS
from ecume.models.tracers.noise_at_walls import acceptance, in_corner
from ecume.models.tracers.record import checked_parameters
from ecume.models.tracers.tank import surfaces_of
from ecume.scenes.schema import from_plain
from ecume.simulation import simulate

SIZE, RADIUS, EXCESS = 1e-5, 1e-7, 1000.0
THERMAL = brownian_motion.thermal_energy(293.15)
SPREAD = brownian_motion.diffusivity(THERMAL, 6.0 * math.pi * 1e-3 * RADIUS)
SIGMA = 0.06
"""The standard deviation of a step, over the size."""
COUNT, FRAMES, STEPS = 6000, 10, 6


def shaped(tank, obstacles, length, seed):
    """A scene whose particles start in equilibrium, and places in equilibrium: uniform, or with a length of settling
    over the size.
    """
    step = (SIGMA * SIZE) ** 2 / (2.0 * SPREAD)
    weight = 4.0 / 3.0 * math.pi * RADIUS**3 * EXCESS
    plain = {
        "model": "tracers", "duration": FRAMES * STEPS * step, "frame_every": STEPS * step, "seed": seed,
        "gravity": THERMAL / (length * SIZE * weight) if length else 0.0, "tank": tank, "obstacles": obstacles,
        "liquid": {"density": 1000.0, "viscosity": 1e-3, "temperature": 293.15},
        "integration": {"time_step": step, "integrator": "overdamped"},
        "hydrodynamics": {"brownian": True, "drag": "stokes"},
    }  # fmt: skip
    dice, one = np.random.default_rng(seed), [{"radius": RADIUS, "density": 1000.0 + EXCESS, "count": 1}]
    surfaces = surfaces_of(from_plain({**plain, "particles": one}))
    places = dice.uniform(-1.5 * SIZE, 1.5 * SIZE, (1_500_000, 2))
    places = places[clearance(places, surfaces)[0] >= RADIUS]
    if length:
        fall = places[:, 1] - places[:, 1].min()
        places = places[dice.uniform(size=len(places)) < np.exp(-fall / (length * SIZE))]
    start, rest = places[:COUNT].tolist(), places[COUNT:]
    grains = [{"radius": RADIUS, "density": 1000.0 + EXCESS, "positions": start}]
    return from_plain({**plain, "particles": grains}), rest, surfaces


def shares_near(corners, scene, rest, surfaces):
    """Shares of particles within steps of the corners, those in equilibrium, and their standard errors."""
    # A scheme that empties corners has done so after two frames.
    found = np.concatenate([frame.arrays["position"] for frame in simulate(scene)][2:])
    assert (clearance(found, surfaces)[0] >= RADIUS * (1.0 - 1e-9)).all()
    far = [np.min([np.hypot(*(some - corner).T) for corner in corners], axis=0) for some in (found, rest)]
    steps = np.array([1.0, 2.0, 4.0])
    share, exact = (np.array([np.mean(away < each * SIGMA * SIZE) for each in steps]) for away in far)
    # Particles stay for steps^2/2 steps, so that frames are not independent.
    memory = 1.0 + steps**2 / STEPS
    return share, exact, np.sqrt(exact * (memory / len(found) + 1.0 / len(rest)))


def wedge(angle):
    """A corner of an angle in degrees at the origin."""
    x, y = SIZE * math.cos(0.5 * math.radians(angle)), SIZE * math.sin(0.5 * math.radians(angle))
    return (
        [(0.0, 0.0), (x, -y), (x, y)] if angle < 130 else [(0.0, 0.0), (x, -y), (x + SIZE, -y), (x + SIZE, y), (x, y)]
    )


@pytest.mark.sampled(4)
@pytest.mark.compiled
@pytest.mark.parametrize("length", [0.0, 0.3])
@pytest.mark.parametrize("angle", [20, 75, 150])
def test_the_density_in_a_corner_of_any_angle_is_that_of_equilibrium(angle, length):
    scene, rest, surfaces = shaped({"vertices": wedge(angle)}, [], length, angle)
    apex = (RADIUS / math.sin(0.5 * math.radians(angle)), 0.0)
    share, exact, error = shares_near([apex], scene, rest, surfaces)
    assert (abs(share - exact) < 4.0 * error).all()


@pytest.mark.compiled
@pytest.mark.parametrize("seed", range(3))
def test_random_shapes_keep_their_equilibrium_at_corners_of_walls_and_obstacles(seed):
    dice = np.random.default_rng(seed)
    cloud = dice.uniform(-1.2, 1.2, (6, 2))
    tank = SIZE * cloud[ConvexHull(cloud).vertices]
    body = tank.mean(axis=0) + 0.25 * SIZE * np.array(
        [(math.cos(a), math.sin(a)) for a in (seed, seed + 2.5, seed + 4.0)]
    )
    scene, rest, surfaces = shaped(
        {"vertices": tank.tolist()}, [{"vertices": body.tolist()}], (0.0, 0.4, 0.25)[seed], seed
    )
    share, exact, error = shares_near([*tank, *body], scene, rest, surfaces)
    assert (abs(share - exact) < 4.0 * error).all()


@pytest.mark.compiled
@pytest.mark.parametrize("length", [0.0, 0.4])
def test_a_round_tank_and_a_round_obstacle_keep_the_equilibrium_beside_them(length):
    inner, outer = 0.3 * SIZE, SIZE
    scene, rest, surfaces = shaped({"radius": outer}, [{"center": [0.2 * SIZE, 0.0], "radius": inner}], length, 5)
    found = np.concatenate([frame.arrays["position"] for frame in simulate(scene)][1:])
    for reach in (0.5 * SIGMA * SIZE, SIGMA * SIZE):
        share, exact = (np.mean(clearance(some, surfaces)[0] < RADIUS + reach) for some in (found, rest))
        assert share == pytest.approx(exact, abs=5.0 * math.sqrt(exact * (1.0 / len(found) + 1.0 / len(rest))))


def test_corners_are_where_walls_meet_that_are_not_at_right_angles():
    box = {"high": [SIZE, SIZE]}
    block = [{"low": [0.4 * SIZE, 0.4 * SIZE], "high": [0.6 * SIZE, 0.6 * SIZE]}]
    base = {"model": "tracers", "duration": 1.0, "frame_every": 1.0, "hydrodynamics": {"brownian": True},
            "integration": {"integrator": "overdamped"}, "tank": box,
            "particles": [{"radius": RADIUS, "density": 1000.0, "count": 1}]}  # fmt: skip
    sheet = checked_parameters(from_plain(base | {"obstacles": block})).mirroring
    sizes, still = (RADIUS, 0.01 * SIZE), (0.0, 0.0, 0.0)

    def there(x, y, drift=still, sheet=sheet, sizes=sizes):
        return in_corner(sheet, (x * SIZE, y * SIZE, 0.0), drift, sizes)

    assert not there(0.02, 0.02), "two walls at a right angle"
    assert not there(0.5, 0.63), "one face of an obstacle"
    assert there(0.59, 0.63), "an edge of it"
    assert there(0.63, 0.63)
    assert there(0.02, 0.5, sizes=(RADIUS, 0.1 * SIZE)), "walls on both sides"
    assert not there(0.59, 0.63, (0.0, 0.006 * SIZE, 0.0)), "a layer thinner than the noise"
    held = checked_parameters(from_plain(base | {"obstacles": [block[0] | {"sticking": True}]})).mirroring
    assert not there(0.59, 0.63, sheet=held), "a face that holds particles"


def test_flights_without_collisions_and_along_walls_are_accepted_and_those_up_a_wall_by_their_weight():
    drift, variance = (0.0, -0.2, 0.0), 1.0
    assert acceptance(drift, (0.3, 0.5, 0.0), (0.3, 0.5, 0.0), variance) == 1.0
    # Mirrored by a floor: the velocities at the ends cancel along its normal.
    assert acceptance(drift, (0.3, 0.5, 0.0), (0.3, 0.0, 0.0), variance) == pytest.approx(math.exp(-0.2))
    assert acceptance(drift, (0.3, -0.5, 0.0), (0.3, 0.0, 0.0), variance) == 1.0


@pytest.mark.parametrize(
    ("tank", "step", "remarked"), [("box", 4.0, False), ("wedge", 4.0, True), ("wedge", 0.5, False)]
)
def test_check_remarks_a_step_whose_noise_exceeds_the_layer_in_corners(tank, step, remarked):
    weight, length = 4.0 / 3.0 * math.pi * RADIUS**3 * EXCESS, 0.1 * SIZE
    plain = {
        "model": "tracers", "duration": 10.0, "frame_every": 10.0, "gravity": THERMAL / (length * weight),
        "tank": {"high": [SIZE, SIZE]} if tank == "box" else {"vertices": wedge(75)},
        "liquid": {"density": 1000.0, "viscosity": 1e-3, "temperature": 293.15},
        "integration": {"integrator": "overdamped", "time_step": 10.0 / math.ceil(10.0 / (step * length**2 / SPREAD))},
        "hydrodynamics": {"brownian": True, "drag": "stokes"},
        "particles": [{"radius": RADIUS, "density": 1000.0 + EXCESS, "count": 1}],
    }  # fmt: skip
    (remark,) = [
        row[2] for row in MODELS["tracers"].summary(from_plain(plain)) if row[0].endswith("sedimentation length")
    ]
    assert ("in corners" in remark) == remarked


def test_no_step_of_a_particle_with_inertia_has_the_noise_of_diffusion():
    """A grain of dust in air has a layer of less than a nanometer, and a relaxation time of 0.4 ms."""
    plain = {
        "model": "tracers", "duration": 0.01, "frame_every": 0.01, "liquid": {"name": "air"},
        "tank": {"vertices": (1e3 * np.array(wedge(75))).tolist()},
        "integration": {"integrator": "inertial", "time_step": 1e-4},
        "hydrodynamics": {"brownian": True, "drag": "stokes"}, "particles": [{"radius": 4e-6, "density": 2000.0}],
    }  # fmt: skip
    (remark,) = [row[2] for row in MODELS["tracers"].summary(from_plain(plain)) if "sedimentation" in row[0]]
    assert remark == "height of the layer in equilibrium"
