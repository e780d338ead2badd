"""A barrier: forces and work compared with closed forms, symmetry, half runs, and refusals."""

import math

import numpy as np
import pytest

from ecume.errors import BadInput, SceneError
from ecume.laws import rafts
from ecume.laws.flotation import Liquid
from ecume.models import MODELS
from ecume.models.floating.dishes import behind_barrier, field_of
from ecume.models.floating.forces.magnets import DipoleMoments
from ecume.models.floating.parameters import CUTOFF, part_of
from ecume.models.liquids import liquid_of
from ecume.models.model import DONE
from ecume.scenes.schema import from_plain
from ecume.show.floating.bowl import Bowl as Picture
from ecume.show.play.bowl import Bowl as PlayedBowl
from ecume.show.view.scenery import floating_stage
from ecume.simulation import simulate
from tests.models import begun

RADIUS, SPEED = 1e-3, 0.005
FLOATING = MODELS["floating"]
PLAIN = pytest.mark.uncompiled
"""Rough walls beside a barrier, which nothing else compiles, for ten seconds; each is compiled without the other. So is
a meniscus beside a barrier with velocity-verlet: it is compiled with overdamped floats, and the integrator without it.
"""


def trough(places, *, barrier=None, integrator="overdamped", dish=None, count=None, **tables):
    """Floats in a trough of 4 cm by 2 cm without menisci, whose left side moves."""
    particles = {"positions": places} if count is None else {"count": count}
    given = {
        "model": "floating", "duration": 1.0, "frame_every": 0.25,
        "liquid": {"density": 1000.0, "viscosity": 1e-3, "surface_tension": 0.0728},
        "particles": [{"radius": RADIUS, "density": 600.0, "contact_angle": 1.2, **particles}],
        "dish": {"size": [0.04, 0.02], "law": "none", "restitution": 0.0, **(dish or {}),
                 "barrier": {"side": "left", "velocity": SPEED, "start": 0.019} | (barrier or {})},
        "hydrodynamics": {"drag": "stokes"}, "interaction": {"law": "none"}, "integration": {"integrator": integrator},
    }  # fmt: skip
    return from_plain(given | tables)


OVAL = {
    "radius": RADIUS,
    "density": 600.0,
    "contact_angle": 1.2,
    "shape": {"kind": "ellipsoid", "width": RADIUS, "angle": 0.0},
}


def friction_of(scene):
    """The drag of a single float over its velocity (N s/m)."""
    floats = FLOATING.parameters(scene).floats
    return float(floats.mass[0] / floats.relaxation_time[0])


def row_of_floats(count):
    return [[2.0 * RADIUS * k, 0.0] for k in range(count)]


@pytest.mark.parametrize("integrator", ["overdamped", "velocity-verlet", "semi-implicit-euler", "explicit-euler"])
@pytest.mark.parametrize("count", [1, 4])
def test_touching_floats_move_with_the_barrier_and_press_on_it_with_their_drag(count, integrator):
    scene = trough(row_of_floats(count), integrator=integrator)
    first, *_, last = simulate(scene)
    moved = last.arrays["position"] - first.arrays["position"]
    assert last.arrays["velocity"][:, 0] == pytest.approx(np.full(count, SPEED), rel=1e-6)
    assert moved[:, 0] == pytest.approx(np.full(count, SPEED), abs=2e-4 * RADIUS)
    drag = count * friction_of(scene) * SPEED
    # With one whole kick for each step, drag acts on the velocity at its beginning.
    tolerance = 1e-6 if integrator in ("overdamped", "velocity-verlet") else 0.05
    assert last.numbers["force_on_left"] == pytest.approx(drag, rel=tolerance)
    assert last.numbers["surface_pressure"] == pytest.approx(drag / 0.02, rel=tolerance)
    assert last.numbers["force_on_right"] == 0.0


@PLAIN
@pytest.mark.parametrize("integrator", ["overdamped", "velocity-verlet"])
def test_ellipsoids_move_with_the_barrier_and_press_on_it_with_their_drag(integrator):
    bodies = [OVAL | {"positions": row_of_floats(3)}]
    scene = trough([], integrator=integrator, particles=bodies, duration=0.1, frame_every=0.05)
    *_, last = simulate(scene)
    assert last.arrays["velocity"][:, 0] == pytest.approx(np.full(3, SPEED), rel=1e-6)
    assert last.arrays["position"][:, 0] == pytest.approx(2.0 * RADIUS * np.arange(3) + 0.1 * SPEED, abs=2e-4 * RADIUS)
    drag = float(FLOATING.parameters(scene).parts.integrator.friction[:, 0].sum()) * SPEED
    assert last.numbers["force_on_left"] == pytest.approx(drag, rel=1e-6)
    assert last.numbers["force_on_right"] == 0.0


def test_the_work_of_the_barrier_is_what_drag_dissipates_and_a_collision_leaves():
    scene = trough(row_of_floats(3), integrator="velocity-verlet", dish={"restitution": 1.0})
    *_, last = simulate(scene)
    assert last.numbers["barrier_work"] == last.numbers["injected_work"]
    assert last.numbers["barrier_work"] > last.numbers["kinetic_energy"]
    undamped = trough(
        [[0.001, 0.0]], integrator="velocity-verlet", dish={"restitution": 1.0}, hydrodynamics={"drag": "none"},
        duration=0.5,
    )  # fmt: skip
    *_, last = simulate(undamped)
    mass = float(last.arrays["mass"][0])
    assert last.arrays["velocity"][0, 0] == pytest.approx(2.0 * SPEED, rel=1e-9)
    assert last.numbers["barrier_work"] == pytest.approx(2.0 * mass * SPEED**2, rel=1e-9)
    assert last.numbers["kinetic_energy"] == pytest.approx(2.0 * mass * SPEED**2, rel=1e-9)


@pytest.mark.long
@pytest.mark.parametrize("integrator", [pytest.param("velocity-verlet", marks=PLAIN), "overdamped"])
@pytest.mark.parametrize(("angle", "law", "image"), [(0.8, "meniscus", "none"), (2.2, "profile", "fixed-angle")])
def test_the_energy_minus_the_work_of_a_barrier_with_a_meniscus_never_rises(angle, law, image, integrator):
    scene = trough(
        [[0.0, 0.0], [0.004, 0.003], [-0.005, 0.002], [0.001, -0.006]], integrator=integrator,
        dish={"law": law, "image": image, "contact_angle": angle}, interaction={},
        barrier={"velocity": 0.01, "start": 0.008, "stop": 0.016}, duration=0.2, frame_every=0.02,
    )  # fmt: skip
    left = [frame.numbers["total_energy"] - frame.numbers["injected_work"] for frame in simulate(scene)]
    assert np.all(np.diff(left) <= 1e-3 * np.ptp(left))


@PLAIN
@pytest.mark.parametrize("law", ["meniscus", "profile"])
def test_a_slow_barrier_does_the_work_of_its_meniscus_on_a_float_that_is_held(law):
    """The liquid is so viscous that nothing moves: the work is the change of the energy of the float."""
    scene = trough(
        [[0.0, 0.0]], dish={"law": law, "contact_angle": 2.2}, interaction={}, integrator="velocity-verlet",
        barrier={"velocity": 0.01, "start": 0.01, "stop": 0.016}, liquid={"viscosity": 1e9, "surface_tension": 0.0728},
    )  # fmt: skip
    first, *_, last = simulate(scene)
    gained = last.numbers["wall_energy"] - first.numbers["wall_energy"]
    assert gained > 0.0
    assert last.numbers["barrier_work"] == pytest.approx(gained, rel=1e-6)


@pytest.mark.parametrize("integrator", ["overdamped", "velocity-verlet"])
def test_a_symmetric_scene_stays_symmetric_between_two_barriers(integrator):
    pairs = [(0.004, 0.0), (0.0011, 0.003)]
    places = [[sign * x, y] for x, y in pairs for sign in (1.0, -1.0)]
    scene = trough(
        places, integrator=integrator, barrier={"both": True, "velocity": 0.02, "start": 0.013, "stop": 0.0155},
        duration=0.2, frame_every=0.1,
    )  # fmt: skip
    *_, last = simulate(scene)
    x, y = last.arrays["position"].T
    assert x[::2] == pytest.approx(-x[1::2], abs=1e-7 * RADIUS)
    assert y[::2] == pytest.approx(y[1::2], abs=1e-7 * RADIUS)
    numbers = last.numbers
    assert numbers["force_on_left"] == pytest.approx(numbers["force_on_right"], rel=1e-6, abs=1e-15)


SIDES = {"left": (1.0, 0.0), "right": (-1.0, 0.0), "bottom": (0.0, 1.0), "top": (0.0, -1.0)}


@pytest.mark.parametrize("side", SIDES)
def test_each_side_can_be_the_barrier(side):
    scene = trough(
        [[0.0, 0.0]], dish={"size": [0.04, 0.04]}, barrier={"side": side, "velocity": SPEED, "start": 0.019},
        duration=0.1, frame_every=0.05,
    )  # fmt: skip
    *_, last = simulate(scene)
    assert last.arrays["position"][0] == pytest.approx(np.array(SIDES[side]) * 0.1 * SPEED, abs=1e-9)
    assert last.numbers[f"force_on_{side}"] == pytest.approx(friction_of(scene) * SPEED, rel=1e-6)


CLOSING = {
    "round": {"size": None, "radius": 0.02}, "rectangle": {"size": [0.04, 0.03]},
    "ellipse": {"size": [0.04, 0.03], "shape": "ellipse"},
}  # fmt: skip
"""Dishes whose walls touch the axes at 2 cm and, unless they are round, at 1.5 cm."""


def closing(places, dish, **barrier):
    return trough(places, dish=dish, barrier={"side": "all", "start": 0.0, **barrier}, duration=0.4, frame_every=0.2)


@pytest.mark.parametrize("shape", CLOSING)
def test_a_wall_that_closes_moves_the_floats_at_it_and_has_their_pressure(shape):
    high = 0.02 if shape == "round" else 0.015
    places = [[0.02 - RADIUS, 0.0], [RADIUS - 0.02, 0.0], [0.0, high - RADIUS], [0.0, RADIUS - high]]
    scene = closing(places, CLOSING[shape])
    *_, last = simulate(scene)
    place = last.numbers["barrier_position"]
    assert place == pytest.approx(0.4 * SPEED, rel=1e-12)
    scaled = np.array(places) * (1.0 - 0.4 * SPEED / np.abs(places).max(axis=1)[:, None])
    assert last.arrays["position"] == pytest.approx(scaled, abs=2e-4 * RADIUS)
    drag = 4.0 * friction_of(scene) * SPEED
    around = sum(math.dist(corners[1], corners[2]) for corners in behind_barrier(scene.dish, place))
    assert last.numbers["surface_pressure"] == pytest.approx(drag / around, rel=1e-5)
    pushed = last.numbers["force_on_left"] * 4.0 if shape == "rectangle" else last.numbers["force_on_wall"]
    assert pushed == pytest.approx(drag, rel=1e-5)
    assert last.numbers["barrier_work"] == pytest.approx(drag * place, rel=1e-3)


def test_two_floats_stop_a_wall_that_closes_where_they_fill_it():
    scene = closing([[0.005, 0.0], [-0.005, 0.0]], CLOSING["round"], start=0.013, velocity=0.02, stop=0.0185)
    first, *_, last = simulate(scene)
    assert last.numbers["barrier_stopped"] == 1.0
    assert last.numbers["barrier_position"] == pytest.approx(0.018, abs=0.02 * RADIUS)
    assert last.numbers["largest_overlap"] < 1e-3 * RADIUS
    picture = Picture(scene, [first, last])
    before, after = (np.array(picture.pixels(frame)) for frame in (first, last))
    assert not np.array_equal(before, after)


@pytest.mark.long
def test_a_barrier_follows_its_table_and_stops_where_it_is_told():
    table = {"velocity": None, "start": 0.0, "times": [0.1, 0.2, 0.4], "positions": [0.0, 0.01, 0.005]}
    scene = trough([[0.01, 0.0]], barrier=table, duration=0.5, frame_every=0.05)
    found = [frame.numbers["barrier_position"] for frame in simulate(scene)]
    expected = np.interp(0.05 * np.arange(11), table["times"], table["positions"])
    assert found == pytest.approx(expected.tolist(), abs=1e-12)
    backward = trough([[0.01, 0.0]], barrier={"velocity": -0.02, "start": 0.003}, duration=0.3, frame_every=0.1)
    assert [frame.numbers["barrier_position"] for frame in simulate(backward)][1:] == pytest.approx([0.001, 0.0, 0.0])


@pytest.mark.long
@pytest.mark.parametrize("integrator", ["overdamped", "velocity-verlet"])
def test_a_packed_raft_stops_the_barrier_before_it_is_squeezed(integrator):
    """A row of floats between barrier and wall has no room after a known displacement."""
    row = [[0.0195 - RADIUS - 2.0 * RADIUS * k, 0.0] for k in range(6)]
    scene = trough(
        row, barrier={"velocity": 0.01, "start": 0.0265, "stop": 0.03}, duration=0.3, frame_every=0.1,
        integrator=integrator,
    )  # fmt: skip
    *_, last = simulate(scene)
    assert last.numbers["barrier_stopped"] == 1.0
    assert last.numbers["barrier_position"] == pytest.approx(0.028, abs=0.01 * RADIUS)
    assert last.numbers["deepest_overlap"] < 1e-3 * RADIUS
    assert last.numbers["largest_speed"] < 1e-9


@pytest.mark.parametrize(("bent", "late"), [(1e-3, True), (0.2, False)])
def test_a_chain_snaps_aside_without_overlap_and_the_barrier_is_late_if_it_would_jump(bent, late):
    """The middle of a chain that is nearly straight would jump over several radii in one step."""
    row = [[0.019, 0.0], [0.017, bent * RADIUS], [0.015, 0.0]]
    scene = trough(row, barrier={"start": 0.0339}, duration=0.1, frame_every=0.002)
    frames = list(simulate(scene))
    assert max(frame.numbers["largest_overlap"] for frame in frames) < 1e-3 * RADIUS
    assert frames[-1].numbers["barrier_stopped"] == 0.0
    assert frames[-1].arrays["position"][1, 1] > 0.5 * RADIUS
    missing = max(0.0339 + f.time * SPEED - f.numbers["barrier_position"] for f in frames)
    assert (missing > 1e-6) == late


def test_velocities_are_those_of_the_motion_where_the_barrier_is_late():
    row = [[0.019, 0.0], [0.017, 1e-3 * RADIUS], [0.015, 0.0]]
    parameters, state, workspace = begun(trough(row, barrier={"start": 0.0339}, duration=0.1, frame_every=0.002))
    time, ways, shares = parameters.time_step, [], []
    for _ in range(60):
        before = state.position.copy()
        assert FLOATING.advance(parameters, state, workspace, 1) == DONE
        moved = np.abs(state.position - before).max()
        ways.append(moved / RADIUS)
        shares.append(time * np.abs(state.velocity).max() / max(moved, 1e-30))
    late = int(np.argmax(ways))
    assert ways[late] == pytest.approx(0.25, rel=0.05)
    assert shares[late] == pytest.approx(1.0, abs=1e-3)


def test_a_barrier_stops_at_the_pressure_that_a_scene_gives():
    drag = 3.0 * friction_of(trough(row_of_floats(3))) * SPEED / 0.02
    for largest, stops in ((0.9 * drag, 1.0), (1.1 * drag, 0.0)):
        *_, last = simulate(trough(row_of_floats(3), barrier={"largest_pressure": largest}, duration=0.5))
        assert last.numbers["barrier_stopped"] == stops


@pytest.mark.long
def test_a_raft_that_is_stopped_keeps_the_energy_that_floats_at_rest_have():
    row = [[0.0195 - RADIUS - 2.0 * RADIUS * k, 0.0] for k in range(6)]
    scene = trough(row, barrier={"start": 0.0265}, duration=0.4, frame_every=0.2, integrator="velocity-verlet")
    *_, last = simulate(scene)
    assert last.numbers["kinetic_energy"] < 1e-20
    assert 0.0 < last.numbers["barrier_work"] < 1e-7


@pytest.mark.parametrize(
    ("changes", "key"),
    [
        ({"dish": {"size": None, "radius": 0.02}}, "dish.barrier"),
        ({"barrier": {"velocity": None, "start": 0.0}}, "dish.barrier.velocity"),
        ({"barrier": {"times": [0.0, 1.0], "positions": [0.0, 0.01]}}, "dish.barrier.velocity"),
        ({"barrier": {"velocity": None, "start": 0.0, "times": [1.0, 0.0], "positions": [0.0, 0.01]}}, "times"),
        ({"barrier": {"stop": 0.001}}, "dish.barrier.stop"),
        ({"barrier": {"velocity": 0.0, "stop": 0.03}}, "dish.barrier.stop: got 0.03 m, which the barrier never"),
        ({"barrier": {"velocity": -SPEED, "start": 0.0}}, "dish.barrier.velocity: got -0.005 m/s, out of the dish"),
        ({"barrier": {"velocity": 0.0, "start": 0.039}}, "dish.barrier.start: the barrier leaves"),
        ({"barrier": {"velocity": -SPEED, "start": 0.039}}, "dish.barrier.start: the barrier leaves"),
        ({"barrier": {"velocity": 0.05}}, "do not fit"),
        ({"dish": {"law": "meniscus"}, "particles": [OVAL | {"count": 1}]}, "dish.law: got a meniscus on a barrier"),
        ({"dish": {"law": "meniscus"}, "barrier": {"velocity": 0.012}}, "menisci of both sides"),
        ({"hydrodynamics": {"brownian": True}}, "floats that diffuse"),
        ({"hydrodynamics": {"interaction": "rotne-prager"}}, "flow of others"),
        ({"integration": {"integrator": "rk4"}}, "which act at the ends of a step"),
        ({"contacts": {"law": "spring-dashpot", "stiffness": 1.0, "restitution": 0.5}}, "impulses that stop floats"),
        ({"barrier": {"side": "all", "both": True}}, "moves every side"),
        (
            {"barrier": {"side": "all", "start": 0.005}, "dish": {"law": "meniscus"}},
            "dish.law: got 'meniscus' at a wall",
        ),
        ({"barrier": {"side": "all", "start": 0.0}, "dish": {"image": "pinned"}}, "dish.image: got 'pinned' at a wall"),
        ({"barrier": {"side": "all", "start": 0.005}}, "dish.barrier.stop: the wall closes by 10 mm, where the floats"),
    ],
)
def test_what_a_barrier_cannot_do_is_refused(changes, key):
    with pytest.raises(SceneError, match=key):
        FLOATING.parameters(trough([[0.0, 0.0]], **changes))


def test_forces_reach_across_the_dish_that_a_barrier_leaves_free_later():
    """Their ranges were cut off at the width between barriers at the start, also for those that move outward."""
    beads = [{"radius": 1e-4, "density": 600.0, "contact_angle": 1.2, "positions": [[0.0, 0.0], [0.002, 0.0]],
              "magnetic_moment": 1e-6}]  # fmt: skip
    cutoffs = []
    for motion in ({"velocity": SPEED, "start": 0.0}, {"velocity": -0.02, "start": 0.017}):
        scene = trough(None, particles=beads, barrier={"both": True, **motion}, interaction={"accuracy": 1e-6})
        magnets = part_of(FLOATING.parameters(scene), DipoleMoments)
        cutoffs.append(magnets.pair[CUTOFF])
    assert cutoffs[0] == cutoffs[1] == pytest.approx(math.hypot(0.04, 0.02))


def test_pictures_show_the_menisci_between_the_barrier_and_the_other_side():
    scene = trough([[0.0, 0.0]], dish={"law": "meniscus", "contact_angle": 0.5}, barrier={"start": 0.01})
    x, y, liquid = np.array([-0.01, 0.005, 0.02]), np.array([0.0]), liquid_of(scene)
    heights = field_of(scene.dish, liquid, x, y, 0.01)[0]
    assert heights[0] == pytest.approx(heights[2], rel=1e-12)
    assert heights[0] > 2.0 * heights[1]
    assert behind_barrier(scene.dish, 0.01)[0][:, 0].tolist() == [-0.02, -0.01, -0.01, -0.02]


@pytest.mark.parametrize("diameter", [1e-5, 1e-3])
def test_a_raft_buckles_where_the_energy_of_its_softest_wave_vanishes(diameter):
    water = Liquid(density=1000.0, surface_tension=0.072, viscosity=1e-3)
    weight, modulus = 0.072 / water.capillary_length**2, rafts.bending_modulus(0.072, diameter)
    longest = rafts.buckling_wavelength(water, diameter)
    q = 2.0 * math.pi / (longest * np.geomspace(0.1, 10.0, 20001))
    energy = modulus * q**4 + (0.072 - rafts.buckling_pressure(water, diameter)) * q**2 + weight
    assert energy.min() == pytest.approx(0.0, abs=1e-6 * weight)
    assert 2.0 * math.pi / q[np.argmin(energy)] == pytest.approx(longest, rel=1e-3)


def drawn(seed):
    """Random floats of two sizes, a barrier that compresses and expands them, menisci, friction and restitution."""
    dice = np.random.default_rng(seed)
    law, side = str(dice.choice(["meniscus", "none", "profile"])), str(dice.choice(list(SIDES)))
    integrator = str(dice.choice(["velocity-verlet", "semi-implicit-euler", "explicit-euler"]))
    table = {"times": [0.0, 0.02, 0.05, 0.06], "positions": [0.0, *dice.uniform(0.0, 3e-3, 3).tolist()]}
    species = [
        {"radius": float(dice.uniform(5e-4, 1.5e-3)), "density": float(dice.uniform(300.0, 1500.0)),
         "contact_angle": float(dice.uniform(0.8, 2.0)), "count": 3}
        for _ in range(2)
    ]  # fmt: skip
    return trough(
        None, integrator=integrator, particles=species, interaction={}, duration=0.06, frame_every=0.01, seed=seed,
        barrier={"velocity": None, "start": 0.0, "side": side, "both": bool(dice.random() < 0.5), **table},
        dish={"size": [0.026, 0.028], "law": law, "contact_angle": float(dice.uniform(0.4, 2.6)),
              "restitution": float(dice.choice([0.0, 0.5, 1.0])), "friction": float(dice.choice([0.0, 0.4]))},
        hydrodynamics={"drag": str(dice.choice(["stokes", "schiller-naumann"]))},
    )  # fmt: skip


@pytest.mark.long
@pytest.mark.parametrize("seed", [pytest.param(0, marks=PLAIN), 1, pytest.param(2, marks=PLAIN)])
def test_random_rafts_keep_their_budget_and_stay_between_the_walls(seed):
    scene = drawn(seed)
    frames = list(simulate(scene))
    left = np.array([frame.numbers["total_energy"] - frame.numbers["injected_work"] for frame in frames])
    moved = max(np.ptp(left), *(abs(frame.numbers["barrier_work"]) for frame in frames))
    assert np.diff(left).max() <= 1e-3 * moved + 1e-18
    assert all(frame.numbers["largest_overlap"] < 1e-3 * frame.arrays["radius"].min() for frame in frames)
    assert frames[-1].numbers["unconverged_steps"] == 0.0


def test_games_and_pages():
    scene = trough([[0.0, 0.0]], dish={"law": "meniscus"}, barrier={"start": 0.005}, duration=0.1, frame_every=0.05)
    frames = list(simulate(scene))
    with pytest.raises(BadInput, match="barrier"):
        PlayedBowl(scene)
    outline = floating_stage(scene, frames).movers(frames[-1])
    assert np.array(outline)[0, :, 0].max() == pytest.approx(-0.02 + frames[-1].numbers["barrier_position"])
    picture = Picture(scene, frames)
    first, last = (np.array(picture.pixels(frame)) for frame in (frames[0], frames[-1]))
    assert not np.array_equal(first, last)
