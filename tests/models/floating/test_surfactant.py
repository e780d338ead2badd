"""Floats that release surfactant: its concentration, its mass, and the forces of the surface tension."""

import math
import re

import numpy as np
import pytest

from ecume.errors import SceneError
from ecume.laws import camphor
from ecume.models import MODELS
from ecume.models.floating.forces.surfactant import (
    BUDGETS,
    LOST,
    RELEASED,
    Surfactant,
    centers_of,
    tension_forces,
    tension_gradient,
    weights_at,
)
from ecume.models.floating.parameters import part_of
from ecume.models.invariants import NumberHistory
from ecume.run.checkpoints import Checkpoint, newest, save
from ecume.run.directory import RunDirectory
from ecume.show.play.bowl import Bowl
from ecume.simulation import simulate
from ecume.units import parse
from tests.models.floating.bowls import scene_of

FLOATING = MODELS["floating"]
pytestmark = pytest.mark.filterwarnings("ignore:integration.time_step")
DISC = "radius = 1.5e-3\ndensity = 980.0\ncontact_angle = 1.57\n"
CELL = "[cell]\nsize = [0.06, 0.06]\n"
FIELD = "diffusivity = 1e-4\ntension_slope = 10.0\nloss_rate = 5.0\nspacing = 5e-4\n"
ALONE = '[interaction]\nlaw = "none"\n'
STOKES = '[hydrodynamics]\ndrag = "stokes"\n'
SEEDS = [pytest.param(seed, marks=pytest.mark.uncompiled) if seed in (1, 4, 7) else seed for seed in range(8)]
"""Nothing else compiles the last combination, for ten seconds; surfactant, dishes and flows are in the others."""


def boats(places, *, release=2e-7, field=FIELD, around=CELL, velocity="[0.0, 0.0]", rest=ALONE + STOKES, step=2e-3,
          drops="", **times):  # fmt: skip
    """Equal discs on clean water at these positions."""
    source = f"[[surfactant.sources]]\nrelease = {release}\n" if release else ""
    return scene_of(
        f"[liquid]\nname = 'water'\n{around}[surfactant]\n{field}{source}{drops}"
        f"[[particles]]\n{DISC}positions = {places}\nvelocity = {velocity}\n{rest}[integration]\ntime_step = {step}\n",
        **times,
    )


def advanced(scene, *parts):
    """Parameters and state after some steps, with a new workspace for each part of the run."""
    parameters = FLOATING.parameters(scene)
    state = FLOATING.start(scene, parameters)
    for steps in parts:
        assert FLOATING.advance(parameters, state, FLOATING.workspace(parameters, state, 1.0), steps) == 0
    return parameters, state


def slowness(spacing):
    """The relative difference of the speed of a disc on the grid from that in closed form on an infinite surface. The
    trail, 2 cm long, ends within the cell.
    """
    field = FIELD.replace("loss_rate = 5.0", "loss_rate = 20.0").replace("5e-4", str(spacing))
    step = "2.5e-4\nintegrator = 'overdamped'"
    scene = boats([[0.03, 0.03]], release=4e-7, field=field, velocity="[0.38, 0.15]", step=step, duration=4.0,
                  frame_every=4.0)  # fmt: skip
    parameters, state = advanced(scene, 800)
    friction = float(parameters.floats.mass[0] / parameters.floats.relaxation_time[0])
    law = camphor.swimming_speed(friction, 1.5e-3, 4e-6, 1e-4, 20.0)
    return 1.0 - float(np.hypot(*state.velocity[0])) / law


@pytest.mark.long
def test_the_speed_of_a_lone_float_converges_to_the_balance_of_propulsion_and_drag():
    """A disc of 1.5 mm with two and four cells per radius, 8 times above the threshold."""
    coarse, fine = slowness(7.5e-4), slowness(3.75e-4)
    assert 0.0 < fine < 0.5 * coarse < 0.05


@pytest.mark.long
@pytest.mark.parametrize(("times_threshold", "grows"), [(0.5, False), (2.0, True)])
def test_a_float_swims_above_the_threshold_and_stops_below_it(times_threshold, grows):
    parameters = FLOATING.parameters(boats([[0.03, 0.03]], release=1e-9))
    floats = parameters.floats
    friction = float(floats.mass[0] / floats.relaxation_time[0])
    release = times_threshold * friction / camphor.threshold_friction(1.5e-3, 10.0, 1e-4, 5.0)
    scene = boats([[0.0301, 0.0302]], release=release, velocity="[1e-4, 0.0]", duration=4.0, frame_every=4.0)
    parameters, state = advanced(scene, 500)
    before = state.velocity.copy()
    assert FLOATING.advance(parameters, state, FLOATING.workspace(parameters, state, 1.0), 500) == 0
    assert (state.velocity[0, 0] > before[0, 0]) == grows
    assert 0.0 < abs(state.velocity[0, 1]) < 0.15 * state.velocity[0, 0]


def rows(scene, name):
    """The rows of `ecume check` with this name."""
    return [row for row in FLOATING.summary(scene) if row[0] == name]


@pytest.mark.long
def test_check_states_the_speed_of_a_lone_float_with_the_drag_of_the_scene():
    """At a Reynolds number of 50, at which the drag is three times as large as by Stokes's law."""
    drag = "[hydrodynamics]\ndrag = 'schiller-naumann'\n"
    scene = boats([[0.03, 0.03]], release=1e-7, velocity="[2e-2, 0.0]", rest=ALONE + drag, duration=1.2,
                  frame_every=1.2)  # fmt: skip
    ((_, speed, remark),) = rows(scene, "swimming speed")
    _, state = advanced(scene, 600)
    assert float(np.hypot(*state.velocity[0])) == pytest.approx(parse(speed, "m/s"), rel=0.1)
    assert "with the radius" not in remark


def test_check_states_the_speeds_of_the_smallest_and_the_largest_source():
    more = "[[particles]]\nradius = 2.5e-3\ndensity = 980.0\ncontact_angle = 1.57\npositions = [[0.01, 0.01]]\n"
    found = rows(boats([[0.03, 0.03]], rest=f"{more}{ALONE}{STOKES}"), "swimming speed")
    assert [row[2].split(" on ")[0] for row in found] == [f"of a lone float with the radius {r} mm" for r in (1.5, 2.5)]
    assert found[0][1] != found[1][1]


def test_a_float_that_would_be_slower_than_any_that_is_seen_is_at_rest():
    """Without loss the speed falls exponentially with the friction."""
    assert camphor.swimming_speed(1.0, 1e-3, 1e-9, 1e-5, 0.0) == 0.0


def test_the_time_step_follows_from_the_steepest_gradient_of_a_drop():
    """Overdamped floats at the edge of the drop move by a fifth of a radius in a good step."""
    drop = "[[surfactant.drops]]\nposition = [0.03, 0.03]\nradius = 3e-3\nmass = 1e-7\n"
    known = {"release": 0.0, "drops": drop, "duration": 1e-3, "frame_every": 1e-3}
    ring = [
        [0.03 + r * math.cos(a), 0.03 + r * math.sin(a)] for r, a in zip((2e-3, 3e-3, 4e-3), (0, 2, 4), strict=True)
    ]
    overdamped = "\nintegrator = 'overdamped'"
    with pytest.raises(SceneError, match=r"time_step: 0.001 s is unstable here") as caught:
        FLOATING.parameters(boats(ring, step=f"1e-3{overdamped}", **known))
    good = float(re.search(r"([0-9.e-]+) s is good", str(caught.value))[1])
    steps = math.ceil(1e-3 / good)
    _, state = advanced(boats(ring, step=f"{1e-3 / steps!r}{overdamped}", **known), 1)
    moved = np.hypot(*(state.position - np.array(ring)).T) / 1.5e-3
    assert 0.02 < moved.max() < 0.2


def test_a_float_at_rest_feels_no_force_of_its_own_anywhere_between_the_nodes():
    for place in np.random.default_rng(1).uniform(0.0, 0.06, (8, 2)).tolist():
        parameters, state = advanced(boats([place], step=1e-3, duration=0.1), 20)
        part = part_of(parameters, Surfactant)
        pull = tension_forces(part, state.concentration, np.array([place]), parameters.floats.radius)
        steepest = part.slope * float(state.concentration.max()) * 1.5e-3
        assert np.abs(pull).max() < 1e-5 * steepest


@pytest.mark.parametrize("seed", range(4))
def test_two_equal_sources_repel_one_another_as_in_closed_form(seed):
    rng = np.random.default_rng(seed)
    one, angle = rng.uniform(0.0, 0.06, 2), rng.uniform(0.0, 2.0 * math.pi)
    other = one + 5e-3 * np.array([math.cos(angle), math.sin(angle)])
    field = FIELD.replace("loss_rate = 5.0", "loss_rate = 40.0")
    scene = boats([one.tolist(), other.tolist()], release=1e-12, field=field, step=1e-3, duration=0.2)
    parameters, state = advanced(scene, 200)
    part = part_of(parameters, Surfactant)
    pull = tension_forces(part, state.concentration, state.position, parameters.floats.radius)
    assert pull[0] == pytest.approx(-pull[1], rel=1e-6)
    law = camphor.source_repulsion(5e-3, 1.5e-3, 10.0 * 1e-12, 1e-4, 40.0)
    assert pull[1] @ (other - one) / 5e-3 == pytest.approx(law, rel=0.02)


def random_scene(seed):
    """A dish or a cell with a few sources, drops and a flow, whatever the integrator."""
    rng = np.random.default_rng(seed)
    flat = 'contact_angle = "90 deg"\n'
    dishes = [f"[dish]\nradius = 0.015\n{flat}", f"[dish]\nsize = [0.03, 0.024]\n{flat}"]
    around = [*dishes, "[cell]\nsize = [0.03, 0.024]\n"][seed % 3]
    center = np.array([0.015, 0.012]) if seed % 3 == 2 else np.zeros(2)
    places = (center + 4e-3 * np.array([[1, 0], [-1, 0.3], [0, -1]]) + rng.uniform(-4e-4, 4e-4, (3, 2))).tolist()
    drop = f"[[surfactant.drops]]\nposition = {center.tolist()}\nradius = 2e-3\nmass = {rng.uniform(1e-10, 1e-9)}\n"
    loss = [0.0, float(rng.uniform(0.5, 20.0))][seed % 2]
    field = f"diffusivity = {rng.uniform(2e-5, 1e-4)}\ntension_slope = 10.0\nloss_rate = {loss}\nspacing = 1e-3\n"
    flow = f"[flow]\nvelocity = [{rng.uniform(-0.01, 0.01)}, 0.005]\n" if seed % 4 > 1 else ""
    integrator = ["velocity-verlet", "overdamped", "semi-implicit-euler", "explicit-euler"][seed % 4]
    rest = f"{flow}{ALONE if seed % 3 == 2 or seed % 4 == 1 else ''}[hydrodynamics]\ndrag = 'stokes'\n"
    scene = boats(places, release=float(rng.uniform(1e-9, 2e-8)), field=field, around=around, drops=drop, rest=rest,
                  step=f"1e-3\nintegrator = '{integrator}'", duration=0.04, frame_every=0.02)  # fmt: skip
    return scene, drop


@pytest.mark.parametrize("seed", SEEDS)
def test_the_mass_of_surfactant_is_kept_to_rounding_and_is_nowhere_negative(seed):
    scene, _ = random_scene(seed)
    first, *_, last = list(simulate(scene))
    start, now, released, lost = (
        first.numbers["surfactant"], last.numbers["surfactant"], last.numbers["surfactant_released"],
        last.numbers["surfactant_lost"],
    )  # fmt: skip
    assert start == pytest.approx(scene.surfactant.drops[0].mass, rel=1e-12)
    assert released == pytest.approx(3 * scene.surfactant.sources[0].release * 0.04, rel=1e-12)
    assert (lost > 0.0) == (scene.surfactant.loss_rate > 0.0)
    assert now + lost == pytest.approx(start + released, rel=1e-12)
    _, state = advanced(scene, 10)
    assert state.concentration.min() >= 0.0


@pytest.mark.parametrize("seed", SEEDS)
def test_the_free_energy_of_surfactant_is_released_lost_carried_and_dissipated(seed):
    scene, _ = random_scene(seed)
    frames = list(simulate(scene))
    first, now = frames[0].numbers, frames[-1].numbers
    terms = {"released": 1.0, "dissipated": -1.0, "carried": 1.0, "lost": -1.0}
    change = sum(sign * now[f"surfactant_energy_{name}"] for name, sign in terms.items())
    scale = sum(abs(now[f"surfactant_energy_{name}"]) for name in terms)
    assert now["surfactant_energy"] - first["surfactant_energy"] == pytest.approx(change, abs=1e-12 * scale)
    assert now["surfactant_energy_dissipated"] > frames[1].numbers["surfactant_energy_dissipated"] > 0.0
    assert (now["surfactant_energy_carried"] != 0.0) == (scene.flow is not None)
    assert not any(value == 0.0 and math.copysign(1.0, value) < 0.0 for value in (*first.values(), *now.values()))
    parameters = FLOATING.parameters(scene)
    for row in FLOATING.invariants(scene, parameters):
        if row in BUDGETS:
            assert row.value(NumberHistory(first, now, now, now)) < 1e-12


def test_a_spreading_spot_dissipates_the_free_energy_of_a_gaussian():
    """F = b M (ln(M/(4 pi D t c0)) - 2) at the time t after the spot was a point: it falls by b M ln(t2/t1)."""
    drop = "[[surfactant.drops]]\nposition = [0.03, 0.03]\nradius = 1e-3\nmass = 1e-12\n"
    field = FIELD.replace("loss_rate = 5.0", "loss_rate = 0.0")
    scene = boats([[0.01, 0.01]], release=0.0, drops=drop, field=field, duration=0.2, frame_every=0.05)
    seen = {round(frame.time, 3): frame.numbers["surfactant_energy_dissipated"] for frame in simulate(scene)}
    # A disc of radius R has the variance R^2/4 of a point source after R^2/(8 D).
    later, last = (time + 1e-6 / (8.0 * 1e-4) for time in (0.05, 0.2))
    assert seen[0.2] - seen[0.05] == pytest.approx(10.0 * 1e-12 * math.log(last / later), rel=0.01)


def test_a_disc_drives_itself_alike_along_all_symmetric_directions():
    """A quarter turn and a mirror image of a scene give the turned and the mirrored motion."""
    turns = [lambda x, y: (x, y), lambda x, y: (-y, x), lambda x, y: (-x, y)]
    pair, found = [(4e-3, 1e-3), (-3e-3, -2e-3)], []
    for turn in turns:
        places = [list(turn(*place)) for place in pair]
        velocity = list(turn(2e-2, 1e-2))
        scene = boats(places, velocity=velocity, around="[dish]\nsize = [0.03, 0.03]\ncontact_angle = '90 deg'\n",
                      duration=0.1)  # fmt: skip
        _, state = advanced(scene, 30)
        found.append(state.position)
    for turn, position in zip(turns[1:], found[1:], strict=True):
        expected = np.array([turn(*place) for place in found[0].tolist()])
        assert position == pytest.approx(expected, abs=1e-12)


@pytest.mark.long
@pytest.mark.uncompiled  # varying flows and surfactant are compiled by others, each without the other
def test_surfactant_of_a_flow_that_varies_is_carried_at_its_times(tmp_path, monkeypatch):
    """A uniform flow that starts from rest and grows carries a spot by half its last velocity times the time."""
    times, axis = np.array([0.0, 0.1]), np.array([0.0, 0.06])
    u = np.zeros((2, 2, 2))
    u[1] = 0.05
    np.savez(tmp_path / "flow.npz", t=times, x=axis, y=axis, u=u, v=np.zeros_like(u))
    drop = "[[surfactant.drops]]\nposition = [0.021, 0.0]\nradius = 2e-3\nmass = 1e-12\n"
    monkeypatch.chdir(tmp_path)
    flow = "[flow.field]\nfile = 'flow.npz'\ninterpolation = 'linear'\n"
    scene = boats([[0.01, 0.0]], release=0.0, drops=drop, around="[dish]\nsize = [0.09, 0.03]\n", step=4e-3,
                  field=FIELD.replace("5e-4", "1.5e-3"), rest=f"{flow}{ALONE}{STOKES}", duration=0.1)  # fmt: skip
    parameters, state = advanced(scene, 25)
    x, _ = centers_of(part_of(parameters, Surfactant))
    place = float(state.concentration.sum(axis=1) @ x / state.concentration.sum())
    assert place - 0.021 == pytest.approx(0.5 * 0.05 * 0.1, rel=1e-3)


def test_a_checkpoint_keeps_the_concentration(tmp_path):
    scene, _ = random_scene(0)
    _, state = advanced(scene, 5)
    home = RunDirectory(tmp_path)
    home.checkpoints.mkdir(parents=True)
    save(home, Checkpoint(state, 0, 5))
    found = newest(home, FLOATING.further_state(scene) or FLOATING.state, 0, lambda path, fault: pytest.fail(fault))
    assert found is not None
    assert all(np.array_equal(one, other) for one, other in zip(state, found.state, strict=True))
    assert FLOATING.further_state(scene_of(f"[dish]\nradius = 0.02\n[[particles]]\n{DISC}")) is None


def test_a_bowl_that_is_played_with_keeps_its_surfactant_until_it_begins_again():
    drop = "[[surfactant.drops]]\nposition = [0.0, 0.0]\nradius = 2e-3\nmass = 1e-9\n"
    bowl = Bowl(boats([[0.01, 0.0]], drops=drop, around="[dish]\nradius = 0.02\ncontact_angle = '90 deg'\n"))
    bowl.play(0.01)
    lost = bowl.frame.numbers["surfactant_lost"]
    there = bowl.integration.state.concentration.copy()
    bowl.drop("cereal", 0.0, 0.01)
    assert lost > 0.0
    assert bowl.frame.numbers["surfactant_lost"] == lost
    assert np.array_equal(bowl.integration.state.concentration, there)
    bowl.begin_again()
    assert bowl.frame.numbers["surfactant"] == pytest.approx(1e-9, rel=1e-12)


def test_a_spot_spreads_as_diffusion_says_and_is_lost_at_its_rate():
    """Without floats that release, the variance grows by 2 D t along each axis."""
    drop = "[[surfactant.drops]]\nposition = [0.03, 0.03]\nradius = 2e-3\nmass = 1e-12\n"
    scene = boats([[0.01, 0.01]], release=0.0, drops=drop, duration=0.2, frame_every=0.2)
    parameters, state = advanced(scene, 50)
    part = part_of(parameters, Surfactant)
    x = (np.arange(120) + 0.5) * 5e-4 - 0.03
    spread = [(one.sum(axis=1) @ x**2) / one.sum() for one in (part.start, state.concentration)]
    assert spread[1] - spread[0] == pytest.approx(2.0 * 1e-4 * 0.1, rel=1e-3)
    area = float(np.prod(part.width))
    assert area * state.concentration.sum() == pytest.approx(1e-12 * math.exp(-0.5), rel=1e-9)
    assert state.surfactant[LOST] == pytest.approx(1e-12 * (1.0 - math.exp(-0.5)), rel=1e-9)
    assert state.surfactant[RELEASED] == 0.0


def test_a_flow_carries_surfactant_along_unless_it_is_not_advected():
    drop = "[[surfactant.drops]]\nposition = [0.02, 0.03]\nradius = 2e-3\nmass = 1e-12\n"
    x, moved = (np.arange(120) + 0.5) * 5e-4, []
    for advected in ("true", "false"):
        scene = boats([[0.01, 0.01]], release=0.0, drops=drop, field=f"{FIELD}advected = {advected}\n",
                      rest=f"[flow]\nvelocity = [0.05, 0.0]\n{ALONE}{STOKES}", duration=0.1)  # fmt: skip
        _, state = advanced(scene, 20)
        moved.append(float(state.concentration.sum(axis=1) @ x / state.concentration.sum()) - 0.02)
    assert moved == pytest.approx([0.05 * 0.04, 0.0], abs=1e-5)


def test_pepper_moves_away_from_a_drop_of_soap():
    drop = "[[surfactant.drops]]\nposition = [0.0, 0.0]\nradius = 3e-3\nmass = 1e-8\n"
    places = [[6e-3, 0.0], [-3e-3, 5e-3], [0.0, -7e-3]]
    scene = boats(places, release=0.0, drops=drop, around="[dish]\nradius = 0.02\ncontact_angle = '90 deg'\n",
                  duration=0.1)  # fmt: skip
    frames = list(simulate(scene))
    before, after = (np.hypot(*frame.arrays["position"].T) for frame in (frames[0], frames[-1]))
    assert (after > before + 1e-5).all()
    assert frames[-1].numbers["injected_work"] > 0.0


def test_the_surface_tension_does_not_become_negative():
    """From the middle of a drop of much soap to clean water it rises by the tension of water, which it lacks there."""
    drop = "[[surfactant.drops]]\nposition = [0.03, 0.03]\nradius = 1e-2\nmass = 1e-4\n"
    part = part_of(FLOATING.parameters(boats([[0.031, 0.03]], release=0.0, drops=drop)), Surfactant)
    assert (part.slope * part.start).max() > 3.0
    outward = tension_gradient(part, part.start)[0][60:, 60]
    assert float(outward.sum()) * part.width[0] == pytest.approx(0.0728, rel=0.01)


def test_a_saturated_surface_pulls_nothing():
    drop = "[[surfactant.drops]]\nposition = [0.03, 0.03]\nradius = 1e-2\nmass = 1e-4\n"
    field = f"{FIELD}largest_fall = 0.03\n"
    parameters, state = advanced(boats([[0.031, 0.03]], release=0.0, drops=drop, field=field), 1)
    part = part_of(parameters, Surfactant)
    assert (part.slope * part.start).max() > 0.06
    pull = tension_forces(part, state.concentration, np.array([[0.031, 0.03], [0.041, 0.03]]), np.full(2, 1.5e-3))
    assert np.abs(pull[0]).max() < 1e-15 < pull[1, 0]


@pytest.mark.long
def test_injected_work_is_the_change_of_the_kinetic_energy_and_the_loss_to_drag():
    scene = boats([[0.0301, 0.0302]], velocity="[0.1, 0.0]", duration=0.4, frame_every=2e-3)
    frames = list(simulate(scene))
    parameters = FLOATING.parameters(scene)
    friction = float(parameters.floats.mass[0] / parameters.floats.relaxation_time[0])
    square = [float(np.sum(frame.arrays["velocity"] ** 2)) for frame in frames]
    gained = frames[-1].numbers["kinetic_energy"] - frames[0].numbers["kinetic_energy"]
    lost = friction * float(np.trapezoid(square, [frame.time for frame in frames]))
    assert frames[-1].numbers["injected_work"] == pytest.approx(gained + lost, rel=2e-3)


def test_the_weights_of_a_disc_near_a_wall_are_in_the_dish_and_sum_to_one():
    scene = boats([[0.0185, 0.0]], around="[dish]\nradius = 0.02\ncontact_angle = '90 deg'\n")
    part = part_of(FLOATING.parameters(scene), Surfactant)
    cells = weights_at(part, np.array([[0.0185, 0.0]]), np.array([1.5e-3]))
    assert cells.weight.sum() == pytest.approx(1.0, rel=1e-14)
    assert not cells.weight[~part.wet[cells.i, cells.j]].any()


@pytest.mark.parametrize(
    ("scene", "says"),
    [
        (lambda: boats([[0.0, 0.0]], around=""), "surfactant: a surfactant needs a dish or a periodic cell"),
        (lambda: boats([[0.0, 0.0]], field=FIELD.replace("5e-4", "2e-3")), r"surfactant\.spacing"),
        (lambda: boats([[0.0, 0.0]], field=f"{FIELD}largest_fall = 0.08\n"), r"largest_fall: .*surface tension, 0\.07"),
        (lambda: boats([[0.0, 0.0]], release=0.0), r"surfactant\.sources: is missing"),
        (lambda: boats([[0.01, 0.01]], rest='[hydrodynamics]\ndrag = "none"\n'), "needs drag"),
    ],
)
def test_what_cannot_be_is_refused_with_the_reason(scene, says):
    with pytest.raises(SceneError, match=says):
        FLOATING.parameters(scene())
