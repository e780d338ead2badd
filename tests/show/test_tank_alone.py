"""A page that simulates a tank by itself moves liquid as ecume does, with the same laws, and refuses what it cannot."""

import base64
import json
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from ecume.errors import BadInput
from ecume.models import MODELS
from ecume.models.model import DONE, EXCHANGE
from ecume.models.sph.parameters import Drive, Liquid
from ecume.models.sph.report.energy_budget import energies
from ecume.models.sph.state import make_state
from ecume.scenes.load import load_scene
from ecume.scenes.templates import folder
from ecume.show.play.alone import MODULES, alone, refusal, save_alone
from ecume.show.play.memory import slots, types_of
from ecume.show.play.tank import Push, Tank, fixed, require_playable, tilting, with_hands
from ecume.show.play.tank_alone import (
    arguments_in,
    divided,
    drops_of,
    gauges_of,
    offered_tank,
    parameters_of,
    tank_arguments,
)
from ecume.show.play.tank_steps import (
    advance,
    lean,
    measure_period,
    measure_wall,
    push_wall,
    put_constant_fields,
)
from ecume.show.view.page import bundled

SPH = MODELS["sph"]
WORKER = Path(__file__).with_name("worker.mjs")
with_node = pytest.mark.skipif(shutil.which("node") is None, reason="node is not installed")
COARSE = ('spacing = "12 cm"',)
POOL = """
model = "sph"
duration = "1 s"
frame_every = "10 ms"
spacing = 0.02
[tank]
low = [0.0, 0.0]
high = [0.4, 0.3]
top = { kind = "open" }
[[fluid]]
low = [0.0, 0.0]
high = [0.14, 0.16]
[liquid]
maximum_speed = 3.0
"""


def scene_of(name, *changes):
    return load_scene((folder() / f"{name}.toml").read_text(encoding="utf-8"), list(changes))


def ours_and_theirs(scene, steps, angle=0.0, liquid=None):
    """The state after some steps of the page, and of the model in a shaken tank."""
    parameters = parameters_of(scene)
    state = SPH.start(scene, parameters) if liquid is None else make_state(parameters, liquid)
    given = arguments_in(parameters, drops_of(state))
    basin, drops, room, _ = given.values()
    room.asked[0] = angle
    lean(basin, drops, room)
    put_constant_fields(basin, drops, room)
    shaken = Drive(np.zeros(1), 0.0, 0.0, 0.0, np.zeros(1), np.array(tilting(scene, angle))[:, None])
    parameters = parameters._replace(moves=True, base_excitation=shaken)
    workspace = SPH.workspace(parameters, state, 1.0)
    statuses = advance(basin, drops, room, steps), SPH.advance(parameters, state, workspace, steps)
    return drops, state, statuses


def assert_same_bits(drops, state):
    for name in ("position", "velocity", "acceleration", "density", "density_rate", "identity", "reference", "clock"):
        np.testing.assert_array_equal(getattr(drops, name), getattr(state, name), err_msg=name)


@pytest.mark.parametrize(
    ("scene", "angle"),
    [
        (scene_of("small-tank", *COARSE), 0.0),
        (scene_of("small-tank", *COARSE), 0.3),
        (scene_of("dam-break", 'spacing = "6 cm"', 'method.pressure_force = "monaghan"'), 0.0),
        (scene_of("dam-break", 'spacing = "6 cm"', 'method.density_diffusion = "none"'), -0.2),
        (scene_of("dam-break", 'spacing = "6 cm"', 'tank.walls = "dummy"'), 0.1),
    ],
    ids=["gate", "gate, tilted", "by mass", "no diffusion", "dummies"],
)
def test_steps_of_a_page_have_the_bits_of_the_model(scene, angle):
    assert refusal(scene) == ""
    drops, state, statuses = ours_and_theirs(scene, 6, angle)
    assert statuses == (DONE, DONE)
    assert_same_bits(drops, state)


@pytest.mark.parametrize("seed", range(3))
def test_liquid_that_flies_about_has_the_bits_of_the_model(seed):
    """Particles that hit walls, gates and each other, at several times the speed of the scene."""
    random = np.random.default_rng(seed)
    scene = load_scene(POOL + "[[obstacles]]\nlow = [0.2, 0.0]\nhigh = [0.24, 0.12]\n", ["spacing = 0.04"])
    parameters = parameters_of(scene)
    start = SPH.start(scene, parameters)
    velocity = 40.0 * random.uniform(-1.0, 1.0, start.velocity.shape)
    liquid = Liquid(start.position, velocity, start.density, start.pressure, start.mass, start.region)
    drops, state, statuses = ours_and_theirs(scene, 8, random.uniform(-0.3, 0.3), liquid)
    assert statuses == (DONE, DONE)
    assert state.tally[1] > 0
    assert_same_bits(drops, state)


def test_liquid_beside_a_wall_that_hands_push_has_the_bits_of_the_model():
    """The wall speeds up, turns, and stops; its path is that of `Push`."""
    scene = scene_of("small-tank", *COARSE)
    driven = SPH.parameters(with_hands(fixed(scene), 0.0, (0.0, 0.0)))
    state = SPH.start(scene, driven)
    basin, drops, room, _ = arguments_in(parameters_of(scene), drops_of(state)).values()
    put_constant_fields(basin, drops, room)
    workspace, push, steps, period = SPH.workspace(driven, state, 1.0), Push(), 6, Tank(scene).period
    for speed in (0.5, 1.0, -0.4, -1.0, 0.0):
        now, seconds = float(state.clock[0]), steps * driven.time_step
        push = push.then(now, seconds, speed, min(float(state.clock[1]), now))
        driven = driven._replace(drives=tuple((side, push.drive()) for side, _ in driven.drives))
        room.asked[:] = speed, seconds
        push_wall(basin, drops, room)
        assert advance(basin, drops, room, steps) == SPH.advance(driven, state, workspace, steps) == DONE
        measure_wall(basin, drops, room)
        assert room.answer[0] == push.at(float(state.clock[0])) != 0.0
        assert_same_bits(drops, state)
    room.asked[0] = 2.4
    measure_period(basin, drops, room)
    assert room.answer[0] == pytest.approx(period, rel=1e-14)


@pytest.mark.parametrize(("gone", "status"), [(1, EXCHANGE), (15, EXCHANGE), (16, DONE)])
def test_liquid_that_leaves_is_told_and_the_last_of_it_stays(gone, status):
    scene = load_scene(POOL, ["spacing = 0.04"])
    parameters = parameters_of(scene)
    start = SPH.start(scene, parameters)
    assert len(start.mass) == 16
    position = start.position.copy()
    position[1, :gone] += 2.0 * parameters.bounds[1, 1]
    liquid = Liquid(position, start.velocity, start.density, start.pressure, start.mass, start.region)
    drops, state, statuses = ours_and_theirs(scene, 3, 0.0, liquid)
    assert statuses == (status, status)
    assert_same_bits(drops, state)


def test_the_compiled_tank_takes_what_ecume_has_now():
    for name in ("small-tank", "dam-break"):
        for precision, module in MODULES.items():
            arguments = tank_arguments(scene_of(name, f'method.precision="{precision}"'))
            assert types_of(arguments) == bundled(f"{module}.types"), "the bundle is old: sh scripts/web"


@pytest.mark.parametrize("count", [1, 2, 8])
def test_only_arrays_of_particles_grow_with_their_number(count):
    """With as many particles as there are tallies, those would be counted as particles by their size."""
    places = [[0.02 + 0.04 * k, 0.02] for k in range(count)]
    text = POOL.replace("low = [0.0, 0.0]\nhigh = [0.14, 0.16]", f"[fluid.particles]\npositions = {places}")
    scene = load_scene(text, ["spacing = 0.04"])
    [sizes] = ({name: sizes for name, _, sizes, _ in case} for case in offered_tank(scene)["slots"])
    for name in ("skin", "clock", "step", "ready", "tally"):
        assert [each for each, _ in sizes[f"drops.{name}"]] == [0], name
    assert sizes["drops.velocity"] == [[0, 2], [1, 0]]


def test_records_keep_their_bits():
    constants = parameters_of(load_scene(POOL)).constants
    [[name, kind, shape, value]] = slots({"constants": constants})
    assert (name, kind, shape) == ("constants", "record 1", [1, 2 * len(constants.dtype.names)])
    assert np.array(value, np.uint32).view(np.float64)[3] == constants["smoothing_length"][0]


@pytest.mark.parametrize(
    ("change", "named"),
    [
        (("liquid.viscosity = 1.0",), "a viscosity"),
        (('method.kernel = "cubic-spline"',), "another kernel"),
        (('integration.integrator = "verlet"',), "verlet"),
        (('method.density_diffusion = "antuono"',), "diffusion"),
        (('tank.walls = "reflect"',), "mirrors"),
        (('tank.left = { kind = "periodic" }', 'tank.right = { kind = "periodic" }'), "periodic"),
        (("spacing = 0.002",), "room for 5000"),
    ],
)
def test_a_tank_that_pages_cannot_simulate_is_refused_by_name(change, named):
    scene = load_scene(POOL, list(change))
    assert named in refusal(scene)
    with pytest.raises(BadInput, match="page"):
        alone(scene)


def test_tanks_in_space_are_refused():
    assert "2D" in refusal(scene_of("dam-break-3d"))


GAUGES = {"near": 0.01, "far": 2.0}
"""The left wall passes the first one."""


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    written = tmp_path_factory.mktemp("page") / "tank.html"
    gauges = "gauges = [" + ", ".join(f'{{name = "{name}", position = [{x}, 0.3]}}' for name, x in GAUGES.items()) + "]"
    written.write_text(alone(scene_of("small-tank", 'spacing = "6 cm"', gauges)), encoding="utf-8")
    return written


def asked(page, *questions):
    done = subprocess.run(
        ["node", str(WORKER), str(page)], input=json.dumps(questions), capture_output=True, text=True, timeout=300
    )
    assert done.returncode == 0, done.stderr
    answers = json.loads(done.stdout)
    assert not [one["fault"] for one in answers if "fault" in one]
    return [one["answer"] for one in answers]


def shown(answer):
    """The positions, velocities and densities that a page shows, (d, N) and (N,)."""
    liquid = answer["liquid"]
    return np.array(liquid["position"]).T, np.array(liquid["velocity"]).T, np.array(liquid["density"])


@pytest.mark.compiled
@with_node
def test_smooth_steps_end_where_those_of_ecume_do(page):
    """A page has vectors of two numbers and no fused products; rounding is all that differs."""
    scene = scene_of("small-tank", 'spacing = "6 cm"')
    smooth, late = asked(page, ["steps", {"steps": 100}], ["steps", {"steps": 300}])
    parameters = parameters_of(scene)
    state = SPH.start(scene, parameters)
    workspace = SPH.workspace(parameters, state, 1.0)
    for answer, steps, close in ((smooth, 100, 1e-12), (late, 300, 1e-9)):
        assert SPH.advance(parameters, state, workspace, steps) == answer["status"] == DONE
        order = np.argsort(state.identity)
        position, velocity, density = shown(answer)
        assert np.abs(position - state.position[:, order]).max() < close
        assert np.abs(velocity - state.velocity[:, order]).max() < 1e3 * close
        assert np.abs(density / state.density[order] - 1.0).max() < 1e2 * close


@with_node
def test_sums_in_single_precision_stay_near_those_in_double(page, tmp_path):
    single = tmp_path / "single.html"
    scene = scene_of("small-tank", 'spacing = "6 cm"', 'method.precision = "single"')
    single.write_text(alone(scene), encoding="utf-8")
    [fine], [coarse] = (shown(*asked(one, ["steps", {"steps": 100}]))[:1] for one in (page, single))
    assert 1e-9 < np.abs(fine - coarse).max() < 1e-5


@pytest.mark.compiled
@with_node
def test_a_dam_that_breaks_keeps_its_mass_and_loses_energy(page):
    said, *answers = asked(page, ["open", {}], *[["steps", {"steps": 200}]] * 6)
    assert said == ""
    scene = scene_of("small-tank", 'spacing = "6 cm"')
    parameters = parameters_of(scene)
    there, fronts = [], []
    for answer in answers:
        liquid = answer["liquid"]
        position, velocity, density = shown(answer)
        mass, region = np.array(liquid["mass"]), np.array(liquid["region"])
        state = make_state(parameters, Liquid(position, velocity, density, np.zeros(len(mass)), mass, region))
        there.append(energies(parameters, state, 0.0, 0.0)["total_energy"])
        fronts.append(position[0, region == 0].max())
        assert mass.sum() == pytest.approx(np.sum(answers[0]["liquid"]["mass"]), rel=1e-15)
    assert np.all(np.diff(there) < 0.0)
    assert fronts[-1] > 1.5 > 1.0 > fronts[0]


@pytest.mark.compiled
@with_node
def test_a_tank_that_is_put_back_leans_no_more(page):
    """Its scene has no [base_excitation], with which it could not be played with again."""
    slightly, back = ["lean", {"angle": 5e-6}], ["lean", {"angle": 0.0}]
    *_, leaning, leans, _, _, upright, stands = asked(
        page, slightly, ["now", {}], ["now", {}], ["scene", {}], back, ["now", {}], ["now", {}], ["scene", {}]
    )
    assert (leaning["leaning"], upright["leaning"]) == (5e-6, 0.0)
    assert "[base_excitation]" in leans
    assert refusal(load_scene(stands)) == ""


@pytest.mark.compiled
@with_node
def test_a_link_brings_the_liquid_back(page):
    """Places come back to 1/65535 of the view, and speeds to 1/8192 of the maximum speed."""
    _, _, there, link, _, said, back, again = asked(
        page, ["open", {}], ["lean", {"angle": 0.1}], ["steps", {"steps": 100}], ["link", {}], ["anew", {}],
        ["bring", {"fragment": "@link"}], ["steps", {"steps": 0}], ["link", {}],
    )  # fmt: skip
    assert (said, again) == ("", link)
    for kept, brought, close in zip(shown(there), shown(back), (4e-5, 5e-4, 0.02), strict=True):
        assert np.abs(kept - brought).max() < close
    assert there["liquid"]["region"] == back["liquid"]["region"]


@pytest.mark.compiled
@with_node
def test_hostile_links_of_tanks_end_in_a_sentence_and_change_nothing(page):
    """The last one puts all liquid into one place: it is brought to rest or begins again, and the page goes on."""
    few = base64.urlsafe_b64encode(bytes([1, 0, 128, 0, 0, 0] + [128] * 12 + [0])).decode()
    wrong = base64.urlsafe_b64encode(bytes([1, 9, 128, 0, 0, 0] + [128] * 12 + [0])).decode()
    region = base64.urlsafe_b64encode(bytes([1, 0, 128, 0, 0, 0] + [128] * 12 + [9])).decode()
    crowd = base64.urlsafe_b64encode(bytes([1, 0, 128, 0, 0, 0] + ([128] * 12 + [0]) * 200)).decode()
    texts = ["", "x", "<script>", "%00", "A" * 100_000, wrong, region]
    before, *said, after = asked(page, ["steps", {"steps": 0}], *(["bring", {"fragment": one}] for one in texts),
                                 ["steps", {"steps": 0}])  # fmt: skip
    assert set(said) == {"The link does not describe a tank of this page."}
    assert after["liquid"] == before["liquid"]
    one, alone, all_, *late = asked(
        page, ["bring", {"fragment": few}], ["steps", {"steps": 1}], ["bring", {"fragment": crowd}], *[["now", {}]] * 30
    )
    assert (one, all_, len(alone["liquid"]["mass"])) == ("", "", 1)
    assert np.isfinite(late[-1]["time"])


@pytest.mark.compiled
@with_node
def test_hands_pour_scoop_and_tilt_and_the_scene_is_kept(page):
    answers = asked(
        page, ["scoop", {"x": 1.8, "y": 0.12}], ["scoop", {"x": 1.8, "y": 1.0}], ["pour", {"x": 1.8, "y": 0.7}],
        ["pour", {"x": 0.36, "y": 0.4}], ["close", {}], ["open", {}], ["open", {}], ["steps", {"steps": 80}],
        ["close", {}], ["lean", {"angle": 9.0}], ["steps", {"steps": 0}], ["now", {}], ["scene", {}],
    )  # fmt: skip
    scooped, nothing, poured, inside, nogate, opened, again, flown, closed, leaned, there, now, text = answers
    assert (scooped, poured, opened, closed, leaned) == ("", "", "", "", "")
    assert (nothing, inside) == ("no liquid here", "no room for liquid here")
    assert (nogate, again) == ("no gate to close", "no gate to open")
    count = len(there["liquid"]["mass"])
    assert len(flown["liquid"]["mass"]) == count
    assert now["opened"] == 0
    x, y = shown(there)[0]
    assert not np.any((x > 0.72) & (x < 0.84) & (y < 1.0)), "liquid is in the closed gate"
    saved = load_scene(text)
    assert sum(len(region.particles.positions) for region in saved.fluid) == count
    assert len(saved.obstacles) == 1
    parameters = SPH.parameters(saved)
    state = SPH.start(saved, parameters)
    assert SPH.advance(parameters, state, SPH.workspace(parameters, state, 1.0), 5) == DONE


@pytest.mark.compiled
@with_node
def test_a_wave_is_made_and_what_is_pushed_is_saved_as_a_tank_to_play_with(page):
    """The wall goes and comes back; the tank of the saved scene ends where the wall stands. A page follows the clock:
    it is asked often enough for the wall to pass the gauge.
    """
    now = ["now", {}]
    made, *seen, text = asked(page, ["wave", {}], *[now] * 12, ["drag", {"x": 9.0}], *[now] * 200, ["scene", {}])
    seen, dragged, pushed = seen[:12], seen[12], seen[-1]
    assert made == dragged == ""
    assert 0.0 < seen[-1]["wall"] < 0.1 * 2.4
    assert seen[-1]["wall"] > seen[3]["wall"]
    saved = load_scene(text)
    assert saved.tank.low[0] == pushed["wall"] > GAUGES["near"]
    assert [gauge.name for gauge in saved.gauges] == ["far"]
    assert refusal(saved) == ""
    require_playable(saved)


@pytest.mark.parametrize("left", [-0.5, 0.0, 0.1, 0.25])
def test_the_place_of_the_left_wall_can_be_written_into_the_scene_of_any_tank(left):
    before, after = divided(load_scene(POOL, [f"tank.low=[{left}, 0.0]"]))
    liquid = "\n[[fluid]]\nlow = [0.38, 0.0]\nhigh = [0.4, 0.1]\n"
    assert load_scene(f"{before}{left + 0.125}{after}{liquid}").tank.low == (left + 0.125, 0.0)


def test_the_tables_of_gauges_are_apart():
    places = ", ".join(f'{{name = "{name}", position = [{x}, 0.3]}}' for name, x in GAUGES.items())
    scene = scene_of("small-tank", f"gauges = [{places}]")
    assert "gauges" not in "".join(divided(scene))
    liquid = "[[fluid]]\nlow = [0.0, 0.0]\nhigh = [0.5, 0.2]\n"
    again = load_scene("".join([str(-1.0).join(divided(scene)), *gauges_of(scene), liquid]))
    assert again.gauges == scene.gauges


def test_the_page_of_a_tank_is_small(tmp_path):
    assert save_alone(scene_of("small-tank"), tmp_path / "tank.html", 1.0) < 400_000
    assert save_alone(scene_of("dam-break"), tmp_path / "dam.html", 1.0) < 500_000
