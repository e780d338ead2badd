"""Half a run and half a run are a run, bit for bit, with each option of each model.

The second half starts from a copy of the state, with a new workspace: whatever a step needs from the one before it must
be in the state. Options alone are tried with a few steps of a small scene; `LONGER` has scenes in which something
happens between: collisions, arrivals, docking.
"""

import dataclasses
import itertools

import numpy as np
import pytest
from tests.contracts import (
    float_options,
    test_soft_option_pairs,
    test_tank_options,
    test_tracer_option_pairs,
)
from tests.models.floating import (
    test_magnetic_fields,
    test_multipoles,
    test_shapes,
    test_surfactant,
    test_undulated_discs,
)
from tests.models.floating.bowls import HEAVY, WATER, bowl, scene_of
from tests.models.sph import (
    test_driven_bodies,
    test_incompressible,
    test_open_boundaries,
    test_passive_particles,
    test_rolling_tanks,
    test_second_liquid,
)
from tests.models.sph.scenes import tank
from tests.models.tracers import test_arrivals

from ecume.scenes.floating import DishSpec
from ecume.scenes.schema import from_plain, to_plain
from ecume.scenes.tracers import (
    FlowSpec,
    ObstacleSpec,
    OpeningSpec,
    ParticleSpec,
    TankSpec,
    TracerHydrodynamicsSpec,
    TracerIntegrationSpec,
    TracersScene,
)
from ecume.simulation import moments

plain_only = pytest.mark.uncompiled  # each combination would be compiled by itself
pytestmark = [
    pytest.mark.filterwarnings("ignore:liu-quartic"),
    pytest.mark.filterwarnings("ignore::ecume.models.tracers.record.FlowWarning"),
]


def copied(state):
    return type(state)(*(array.copy() for array in state))


def states(scene, pauses, state=None, laws=()):
    """Copies of the state after each step, or after several if steps are fast."""
    several = itertools.islice(moments(scene, state=state, extra_laws=laws, patience=0.0), pauses + 1)
    return [copied(moment.state) for moment in several]


def require_halves_to_make_a_whole(scene, pauses=6, laws=()):
    """Compare a run with one that continues from a copy of its state in the middle."""
    whole = states(scene, pauses, laws=laws)
    middle = whole[len(whole) // 2]
    resumed = states(scene, len(whole) - 1 - len(whole) // 2, copied(middle), laws)
    assert int(middle.step[0]) < int(whole[-1].step[0])
    for name, one, other in zip(whole[-1]._fields, whole[-1], resumed[-1], strict=True):
        assert np.array_equal(one, other), name
    return whole[-1]


TOUCHING = [(0.0, 0.0), (6.0001e-5, 0.0), (3.0e-5, 4.8470e-5)]
"""Where the three floats of `float_options` are so close that they collide in the first steps (m)."""
SPEEDS = ["[0.02, 0.003]", "[-0.02, 0.0]", "[0.0, -0.02]"]
TOGETHER = [
    ("friction", "round dish"),
    ("friction", "barrier"),
    ("rolling friction", "round dish"),
    ("rolling friction", "noise"),
    ("springs", "noise"),
    ("noise", "flow of neighbors", "friction"),
    ("noise", "flow of neighbors", "no contacts"),
    ("noise", "shapes"),
    ("noise", "velocity-verlet"),
    ("noise", "stormer-verlet"),
    ("friction", "rk4"),
    ("rolling friction", "stormer-verlet"),
    ("waves", "friction"),
    ("waves", "friction", "overdamped"),
    ("waves", "multipole"),
    ("dish in motion", "rk4"),
    ("active forces", "stormer-verlet"),
    ("fast drag", "stormer-verlet"),
    ("shapes", "waves"),
    ("shapes", "barrier"),
    ("shapes", "periodic cell"),
    ("one-sided law", "friction"),
    ("one-sided law", "films"),
]
"""Options whose states meet only together."""


def colliding_floats(*names):
    """A scene with these options in which floats touch."""
    plain = to_plain(float_options.scene_with(*names))
    for species, speed in zip(plain["particles"], SPEEDS, strict=False):
        species["velocities"] = [eval(speed)]
    return from_plain(plain)


@plain_only
@pytest.mark.parametrize("names", [*((name,) for name in float_options.OPTIONS), *TOGETHER], ids=" and ".join)
def test_half_a_run_of_floats_with_an_option(names, monkeypatch):
    float_options.shorten_tables(monkeypatch.setattr)
    monkeypatch.setattr(float_options, "PLACES", TOUCHING)
    require_halves_to_make_a_whole(colliding_floats(*names))


@pytest.mark.sampled(4)
@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=test_tank_options.marks((name,))) for name in test_tank_options.OPTIONS],
)
def test_half_a_run_of_a_tank_with_an_option(name):
    require_halves_to_make_a_whole(test_tank_options.scene_with((name,)), pauses=4)


@pytest.mark.sampled(4)
@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=test_soft_option_pairs.marks(name)) for name in test_soft_option_pairs.OPTIONS]
)
def test_half_a_run_of_soft_spheres_with_an_option(name):
    # Nothing but drag holds spheres without walls against their weight.
    plain = test_soft_option_pairs.plain_of(name, "hydrodynamics.drag" if name == "gravity" else name)
    laws = test_soft_option_pairs.LAWS if "user_laws" in plain else ()
    require_halves_to_make_a_whole(from_plain(plain), laws=laws)


@pytest.mark.sampled(2)
@pytest.mark.compiled
@pytest.mark.parametrize("name", test_tracer_option_pairs.OPTIONS)
def test_half_a_run_of_tracers_with_an_option(name):
    require_halves_to_make_a_whole(from_plain(test_tracer_option_pairs.plain_of(name, name)), pauses=20)


def scene_with_deposits(seed):
    """Particles that enter, diffuse, fly and adhere to some walls and a disc, in a random flow."""
    rng = np.random.default_rng(seed)
    flow = {"name": "channel", "speed": 0.01} if seed % 2 else {"velocity": rng.uniform(-0.01, 0.01, 2).tolist()}
    walls = [{"wall": int(wall), "sticking": True} for wall in rng.choice([0, 1, 3], 2, replace=False)]
    dust = {"density": 2500.0, "count": 20}
    return from_plain({
        "model": "tracers", "duration": 0.04, "frame_every": 0.002, "seed": seed, "flow": flow,
        "liquid": {"temperature": 350.0}, "hydrodynamics": {"brownian": True}, "integration": {"time_step": 5e-4},
        "tank": {"high": [1e-3, 5e-4], "walls": walls},
        "obstacles": [{"center": rng.uniform([4e-4, 2e-4], [6e-4, 3e-4]).tolist(), "radius": 1e-4, "sticking": True}],
        "openings": [{"wall": 2, "low": [1e-3, 1e-4], "high": [1e-3, 4e-4], "rate": 800.0, "velocity": [-0.02, 0.0]}],
        "particles": [{"radius": 1e-7, **dust}, {"radius": 4e-5, "velocity": [-0.03, 0.02], **dust}],
    })  # fmt: skip


@plain_only
@pytest.mark.parametrize("seed", range(4))
def test_deposits_are_the_same_after_a_pause(seed):
    scene = scene_with_deposits(seed)
    half = copied(states(scene, 10)[-1])
    whole, holes = require_halves_to_make_a_whole(scene, pauses=20), len(scene.openings)
    before, after = half.left >= holes, whole.left >= holes
    assert 0 < before.sum() < after.sum() < len(after)
    np.testing.assert_array_equal(whole.left[: len(before)][before], half.left[before])
    np.testing.assert_array_equal(whole.position[: len(before)][before], half.position[before])


def changed(scene, **tables):
    return from_plain({**to_plain(scene), **tables})


def rafts():
    """Thirty floats that gather in a dish."""
    return scene_of(
        f"{WATER}[[particles]]\ncount = 30\n{HEAVY}[dish]\nradius = 0.012\nfriction = 0.2\n"
        "[contacts]\nfriction = 0.4\n",
        duration=0.5,
        frame_every=0.05,
    )


def beads_in_a_turning_field():
    field = "amplitude = [2e-3, 2e-3, 0.0]\nfrequency = 5.0\nphase = [0.0, -1.5707963, 0.0]\n"
    return test_magnetic_fields.beads([(0.0, 0.0), (1.4e-3, 2e-4)], field)


def discs_in_a_dish(method):
    places = np.array([[0.0, 0.0], [3.1e-3, 0.0], [1.0e-3, 3.0e-3]])
    return test_multipoles.discs(places, method, dish=DishSpec(radius=8e-3), order=5)


def shaken_tank():
    """A piston, a base excitation and a body."""
    plain = to_plain(tank())
    plain["tank"]["right"]["motion"] = {"amplitude": 0.05, "frequency": 1.0}
    plain["base_excitation"] = {"amplitude": [0.05, 0.0], "frequency": 1.0}
    plain["bodies"] = [{"center": [0.5, 1.1], "radius": 0.2, "density": 0.5, "velocity": [0.0, -1.0]}]
    return from_plain(plain)


def grains_in_eddies():
    spec = {"count": 20, "low": [0.01, 0.01], "high": [0.02, 0.02], "turbulent_dispersion": True}
    return test_passive_particles.cup(spec, turbulence="smagorinsky", jitter=0.2)


def noisy_grains():
    grains = ParticleSpec(radius=2e-6, density=2500.0, count=300)
    return TracersScene(
        duration=0.1,
        frame_every=0.025,
        particles=(grains, dataclasses.replace(grains, radius=1e-5)),
        tank=TankSpec(high=(1e-4, 1e-4), restitution=0.5),
        obstacles=(ObstacleSpec(center=(5e-5, 5e-5), radius=2e-5),),
        hydrodynamics=TracerHydrodynamicsSpec(brownian=True),
        integration=TracerIntegrationSpec(time_step=1e-4),
        seed=4,
    )


def arriving_grains():
    return test_arrivals.channel(
        gravity=9.81,
        flow=FlowSpec(velocity=(0.5, 0.0)),
        hydrodynamics=TracerHydrodynamicsSpec(brownian=True),
        integration=TracerIntegrationSpec(time_step=0.01),
        duration=1.0,
        frame_every=0.25,
        openings=(
            OpeningSpec(wall=0, low=(0.0, 0.1), high=(0.0, 0.6), rate=37.0),
            OpeningSpec(wall=3, low=(0.2, 0.8), high=(0.4, 0.8), rate=11.0, species="sand"),
        ),
    )


def docking_ellipsoids():
    return test_shapes.ellipsoid_pair(0.5, -0.4, apart=1.05e-3, duration=0.2, frame_every=0.1)


LONGER = {
    "a channel with inflow and outflow": (test_open_boundaries.channel, 80, ()),
    "an incompressible tank": (lambda: test_incompressible.tank(8), 12, ()),
    "a shaken tank with a body": (shaken_tank, 60, ()),
    "a body on a path": (lambda: test_driven_bodies.driven(test_driven_bodies.LAWS["table"]), 20, ()),
    "solids that formulas move": (test_driven_bodies.moved_by_formulas, 40, ()),
    "a tank that rolls": (test_rolling_tanks.basin, 30, ()),
    "stacked liquids": (lambda: test_second_liquid.stacked(5.0, deep=8, method={"jitter": 0.1}), 8, (plain_only,)),
    **{
        f"surfactant, random scene {seed}": (lambda seed=seed: test_surfactant.random_scene(seed)[0], 12, (plain_only,))
        for seed in range(8)
    },
    "grains in eddies": (grains_in_eddies, 6, ()),
    "rough rafts": (rafts, 10_000, (pytest.mark.long,)),
    "a bowl": (lambda: bowl(30, duration=0.5, frame_every=0.05), 10_000, ()),
    "beads in a turning field": (beads_in_a_turning_field, 10, (plain_only,)),
    "multipoles in a dish": (lambda: discs_in_a_dish("multipole"), 10_000, (pytest.mark.long,)),
    "corrected pairs in a dish": (lambda: discs_in_a_dish("pair-corrected"), 10_000, (pytest.mark.long,)),
    "discs that turn": (lambda: test_undulated_discs.pair((0.5, None), mode=3), 10_000, (pytest.mark.long,)),
    "ellipsoids that dock": (docking_ellipsoids, 10_000, (pytest.mark.long,)),
    "grains that diffuse and bounce": (noisy_grains, 10_000, ()),
    "grains that arrive": (arriving_grains, 10_000, ()),
}
"""By name: the scene, the number of steps, and further marks."""


@pytest.mark.parametrize(
    ("build", "pauses"),
    [
        pytest.param(build, pauses, id=name, marks=[*marks, *([] if plain_only in marks else [pytest.mark.compiled])])
        for name, (build, pauses, marks) in LONGER.items()
    ],
)
def test_half_a_run_in_which_something_happens(build, pauses):
    require_halves_to_make_a_whole(build(), pauses)
