"""Brownian tracers at walls, in gases, and in flows that obstacles do not stop."""

import numpy as np
import pytest

import ecume
from ecume.errors import SceneError
from ecume.laws import brownian_motion
from ecume.models import MODELS
from ecume.models.tracers.record import FlowWarning
from ecume.scenes.load import load_scene
from ecume.scenes.schema import from_plain
from ecume.scenes.tracers import (
    FluidSpec,
    ParticleSpec,
    TankSpec,
    TracerHydrodynamicsSpec,
    TracersScene,
)

COUNT, HEIGHT, RADIUS, EXCESS = 1500, 60e-6, 0.5e-6, 101.8
BROWNIAN = TracerHydrodynamicsSpec(brownian=True)


def equilibrium(length, dice):
    """Heights of centers in a layer with this length, in a box."""
    room = HEIGHT - 2.0 * RADIUS
    return RADIUS - length * np.log1p(-dice.uniform(size=COUNT) * -np.expm1(-room / length))


@pytest.mark.compiled
def test_the_layer_of_settling_particles_is_barometric_from_contact_on():
    dice = np.random.default_rng(5)
    weight = 4.0 / 3.0 * np.pi * RADIUS**3 * EXCESS * 9.81
    length = brownian_motion.sedimentation_length(brownian_motion.thermal_energy(293.15), weight)
    places = np.column_stack([dice.uniform(RADIUS, HEIGHT - RADIUS, COUNT), equilibrium(length, dice)])
    grains = ParticleSpec(radius=RADIUS, density=998.2 + EXCESS, positions=tuple(map(tuple, places.tolist())))
    scene = TracersScene(
        duration=1600.0, frame_every=20.0, seed=5, particles=(grains,), tank=TankSpec(high=(HEIGHT, HEIGHT)),
        liquid=FluidSpec(density=998.2, viscosity=1.0016e-3, temperature=293.15), hydrodynamics=BROWNIAN,
    )  # fmt: skip
    gap = np.concatenate([frame.arrays["position"][:, 1] for frame in ecume.simulate(scene)]) - RADIUS
    assert gap.min() > 0.0, "nobody is exactly at the floor"
    edges = np.array([0.0, 0.1e-6, 0.5e-6, 2e-6, 8e-6, 20e-6])
    share = np.diff(np.exp(-edges / length)) / np.expm1(-(HEIGHT - 2.0 * RADIUS) / length)
    counts = np.histogram(gap, edges)[0]
    # Of numbers that are not independent: the memory of a layer is its crossing, a step or more.
    assert counts / len(gap) == pytest.approx(share, rel=0.03, abs=3.0 * np.sqrt(share.max() * 4 / len(gap)))


@pytest.mark.compiled
@pytest.mark.parametrize("sides", [3, 4, 5, 12, 48])
def test_a_uniform_density_stays_so_between_any_number_of_walls(sides):
    dice, inner, layer = np.random.default_rng(sides), 10e-6, 0.05
    angle = 2.0 * np.pi * np.arange(sides) / sides
    corners = np.stack([np.cos(angle), np.sin(angle)], axis=1) / np.cos(np.pi / sides)
    normal = np.stack([np.cos(angle + np.pi / sides), np.sin(angle + np.pi / sides)], axis=1)
    places = dice.uniform(-2.0, 2.0, (60 * COUNT, 2))
    places = places[np.max(places @ normal.T, axis=1) < 1.0][:COUNT]
    spread = brownian_motion.diffusivity(brownian_motion.thermal_energy(293.15), 6.0 * np.pi * 1e-3 * RADIUS)
    step = 0.01 * inner**2 / spread
    scene = from_plain({
        "model": "tracers", "gravity": 0.0, "duration": 200 * step, "frame_every": 5 * step, "seed": sides,
        "tank": {"vertices": ((inner + RADIUS) * corners).tolist()}, "integration": {"time_step": step},
        "hydrodynamics": {"brownian": True, "drag": "stokes"},
        "particles": [{"radius": RADIUS, "density": 998.0, "positions": (inner * places).tolist()}],
    })  # fmt: skip
    places = np.concatenate([frame.arrays["position"][:, :2] for frame in ecume.simulate(scene)]) / inner
    share = np.mean(np.max(places @ normal.T, axis=1) > 1.0 - layer)
    expected = 1.0 - (1.0 - layer) ** 2
    # Particles cross the layer in half a step, so that the counts of different frames are independent.
    assert share == pytest.approx(expected, abs=4.0 * np.sqrt(expected / len(places)))


def test_particles_in_front_of_an_opening_leave_through_it_and_no_others():
    scene = load_scene(
        'model = "tracers"\nduration = 40.0\nframe_every = 10.0\nseed = 2\n[tank]\nhigh = [1e-5, 1e-5]\n'
        "[hydrodynamics]\nbrownian = true\n[integration]\ntime_step = 0.5\n"
        "[[openings]]\nwall = 0\nlow = [0.0, 0.0]\nhigh = [0.0, 1e-5]\n"
        "[[particles]]\ncount = 40\nradius = 5e-7\ndensity = 1000.0\n"
    )
    *_, last = ecume.simulate(scene)
    inside = last.arrays["left"] < 0
    assert 0 < inside.sum() < 40
    place = last.arrays["position"][inside]
    assert np.all((place > 5e-7) & (place < 1e-5 - 5e-7))


def settling(radius, **medium):
    """The speed at which a sphere of the density of water settles in a gas (m/s)."""
    grain = ParticleSpec(radius=radius, density=1000.0, positions=((0.01, 0.015),))
    scene = TracersScene(
        duration=1.0, frame_every=1.0, particles=(grain,), tank=TankSpec(high=(0.02, 0.02)), liquid=FluidSpec(**medium)
    )
    return MODELS["tracers"].parameters(scene).bodies.settling[0], MODELS["tracers"].summary(scene)


@pytest.mark.parametrize(("radius", "speed"), [(50e-9, 8.7e-7), (500e-9, 3.51e-5)])
def test_small_particles_slip_through_air(radius, speed):
    air = {"density": 1.2, "viscosity": 1.81e-5}
    assert settling(radius, **air, mean_free_path=66.5e-9)[0] == pytest.approx(speed, rel=5e-3)
    assert settling(radius, name="air")[0] == pytest.approx(speed, rel=2e-2)
    slow, rows = settling(radius, **air)
    assert any("set liquid.mean_free_path" in remark for _, _, remark in rows)
    assert settling(radius, density=1000.5, viscosity=1e-3)[1] != rows
    assert slow < speed


def test_a_remark_states_the_slip_from_a_knudsen_number_of_a_hundredth():
    for radius, shown in ((6.4e-6, True), (6.8e-6, False)):
        rows = settling(radius, density=1.2, viscosity=1.81e-5, mean_free_path=66.5e-9)[1]
        assert any("Knudsen" in name for name, _, _ in rows) == shown


OBSTACLE = """\
model = "tracers"
duration = 6.0
frame_every = 0.1
[tank]
high = [2e-3, 1e-3]
[flow]
velocity = [1e-3, 0.0]
[[obstacles]]
center = [1e-3, 5e-4]
radius = 2e-4
[[particles]]
count = 4
radius = 1e-6
density = 998.2
"""


def test_a_flow_through_an_obstacle_is_a_warning_with_its_size():
    with pytest.warns(FlowWarning, match=r"does not go around obstacles.*Stokes number 1\.7e-06.*1 mm/s"):
        rows = MODELS["tracers"].summary(load_scene(OBSTACLE))
    assert any(name == "flow through obstacle 0" for name, _, _ in rows)


@pytest.mark.parametrize(
    ("text", "corners", "expected"),
    [
        ("1e8 1/m^2", 2, 1e8), ("100 1/mm^2", 2, 1e8), ("1e14 m^-3", 3, 1e14), ("100 1/mL", 3, 1e8), (5.0, 3, 5.0),
        ("1 fmol/L", 3, 6.02214076e11), ("2 pmol/m^2", 2, 1.204428152e12),
    ],
)  # fmt: skip
def test_a_concentration_has_the_unit_of_its_dimension(text, corners, expected):
    made = opening(text, corners)
    assert made.openings[0].concentration == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(("text", "corners"), [("1e8 1/m^3", 2), ("1e8 1/m^2", 3), ("1 fmol/L", 2)])
def test_a_concentration_of_another_dimension_is_refused(text, corners):
    with pytest.raises(SceneError, match=r"openings\[0\].concentration"):
        opening(text, corners)


@pytest.mark.parametrize("text", ["1 nM", "1 mol", "100 per mL", "100 mL", "1e6"])
@pytest.mark.parametrize("corners", [2, 3])
def test_a_concentration_in_no_fitting_unit_is_refused_with_that_of_each_dimension(text, corners):
    with pytest.raises(SceneError, match=r"concentration: got '.*'100 1/mm\^2' in 2D, or 1/m\^3 in 3D"):
        opening(text, corners)


def opening(concentration, corners):
    """A scene with an inflow."""
    return from_plain({
        "model": "tracers", "duration": 1.0, "frame_every": 0.1, "tank": {"high": [1e-3] * corners},
        "openings": [{"wall": 0, "low": [0.0] * corners, "high": [0.0] + [1e-3] * (corners - 1),
                      "concentration": concentration, "velocity": [1e-3] + [0.0] * (corners - 1)}],
        "particles": [{"count": 1, "radius": 1e-6, "density": 1050.0}],
    })  # fmt: skip
