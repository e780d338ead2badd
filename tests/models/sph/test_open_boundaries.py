"""In- and outflows, and who is lost."""

import numpy as np
import pytest

import ecume
from ecume.errors import SceneError
from ecume.laws.flows import channel_speed
from ecume.models.model import EXCHANGE
from ecume.models.sph.boundaries.open_boundaries import speed_at
from ecume.models.sph.record import SPH
from ecume.models.sph.state import ENTERED, LEFT, LOST, NEXT
from ecume.scenes.schema import from_plain, to_plain
from tests.models.sph.scenes import OPEN, tank


def channel(**more):
    plain = {
        "model": "sph",
        "duration": 1.5,
        "frame_every": 0.5,
        "spacing": 0.1,
        "gravity": [0.0, 0.0],
        "liquid": {"density": 1.0, "viscosity": 0.05},
        "tank": {
            "low": [0.0, 0.0],
            "high": [2.0, 1.0],
            "left": {"kind": "inflow", "speed": 1.0, "profile": "parabolic"},
            "right": {"kind": "outflow"},
        },
        "fluid": [{"low": [0.0, 0.0], "high": [2.0, 1.0], "flow": "poiseuille"}],
    }
    return from_plain({**plain, **more})


def integrated_through(scene, steps, state=None):
    parameters = SPH.parameters(scene)
    state = SPH.start(scene, parameters) if state is None else state
    workspace, last = SPH.workspace(parameters, state, 1.0), int(state.step[0]) + steps
    while state.step[0] < last:
        if SPH.advance(parameters, state, workspace, last - int(state.step[0])) == EXCHANGE:
            state = SPH.exchange(parameters, state)
            workspace = SPH.workspace(parameters, state, 1.0)
    return state


@pytest.mark.compiled
@pytest.mark.long
@pytest.mark.parametrize("seed", range(4))
def test_random_channels_with_a_parabola_keep_flux_and_number_of_particles(seed):
    """Smoothing lengths of 1.5 spacings, 8 to 12 particles across. Half of the pressure drop 12 eta u L/H^2, over
    rho c^2, is the mean compression.
    """
    dice = np.random.default_rng(seed)
    across = int(dice.integers(8, 13))
    length = int(dice.integers(16, 26)) / across
    plain = to_plain(channel(duration=4.0, frame_every=0.1, spacing=1.0 / across))
    plain["liquid"]["viscosity"] = float(dice.uniform(0.02, 0.2))
    plain["tank"] |= {"high": [length, 1.0], "walls": str(dice.choice(["mirror", "dummy"]))}
    plain["fluid"][0]["high"] = [length, 1.0]
    plain["method"] |= {"smoothing_ratio": 1.5}
    frames = list(ecume.simulate(from_plain(plain)))
    counts = [len(frame.arrays["mass"]) for frame in frames]
    compression = 6.0 * plain["liquid"]["viscosity"] * length / 15.0**2
    flux = [float(frame.arrays["mass"] @ frame.arrays["velocity"][:, 0]) / length for frame in frames[10:]]
    assert np.mean(counts[10:]) / counts[0] == pytest.approx(1.0 + compression, abs=0.006)
    assert np.mean(flux) == pytest.approx(1.0, abs=0.01)
    errors = []
    for frame in frames[20:]:
        exact = np.array([channel_speed(height, 1.0, 1.0) for height in frame.arrays["position"][:, 1]])
        errors.append(np.sqrt(np.mean((frame.arrays["velocity"][:, 0] - exact) ** 2)))
    assert np.mean(errors) < 0.03


@pytest.mark.long
@pytest.mark.compiled
def test_a_parabola_that_flows_in_flows_out_as_one():
    frames = list(ecume.simulate(channel()))
    arrays = frames[-1].arrays
    (_, y), (u, v) = arrays["position"].T, arrays["velocity"].T
    exact = np.array([channel_speed(height, 1.0, 1.0) for height in y])
    assert np.sqrt(np.mean((u - exact) ** 2)) < 0.05
    assert np.abs(v).max() < 0.05
    numbers = frames[-1].numbers
    assert numbers["particles_entered"] == pytest.approx(150, abs=10)
    assert len(u) == pytest.approx(200, abs=8)
    assert (numbers["particles_lost"], numbers["guard_hits"]) == (0, 0)


@pytest.mark.compiled
@pytest.mark.parametrize("walls", ["mirror", "dummy"])
def test_whoever_comes_leaves_a_place_to_one_more_and_all_are_counted(walls):
    plain = to_plain(channel())
    scene = from_plain({**plain, "tank": {**plain["tank"], "walls": walls}})
    state = SPH.start(scene, SPH.parameters(scene))
    before = state.position.shape[1]
    state = integrated_through(scene, 120, state)
    came, left, lost, after = (int(state.population[k]) for k in (ENTERED, LEFT, LOST, NEXT))
    assert came > 30
    assert left > 20
    assert state.position.shape[1] == before + came - left - lost
    assert after == before + came
    assert len(np.unique(state.identity)) == len(state.identity)


def test_what_leaves_through_an_outflow_leaves_along_it():
    scene = channel()
    parameters = SPH.parameters(scene)
    state = SPH.start(scene, parameters)
    one = int(np.argmax(np.where(state.zone == 0, state.position[0], -np.inf)))
    state.position[0, one], state.velocity[:, one], name = 2.01, [0.7, 0.3], state.identity[one]
    state = SPH.exchange(parameters, state)
    (now,) = np.flatnonzero(state.identity == name)
    assert state.zone[now] > 0
    assert state.velocity[:, now].tolist() == [0.7, 0.0]


def test_profiles_have_the_mean_that_was_asked_for():
    for level in (None, 0.6):
        plain = to_plain(channel())
        plain["tank"]["left"]["level"] = level
        (opening, _) = SPH.parameters(from_plain(plain)).open_boundaries
        heights = (np.arange(1000) + 0.5) / 1000 * (level or 1.0)
        speeds = speed_at(opening, np.stack([np.zeros(1000), heights], axis=1))
        assert speeds.mean() == pytest.approx(1.0, rel=1e-4)
        assert (speeds[-1] < 0.01) == (level is None)


@pytest.mark.compiled
def test_a_stream_with_a_surface_keeps_its_level():
    plain = to_plain(channel())
    plain["tank"] |= {
        "left": {"kind": "inflow", "speed": 0.5, "level": 0.5},
        "right": {"kind": "outflow", "level": 0.5},
        "top": OPEN,
    }
    plain |= {"gravity": [0.0, -1.0], "liquid": {"density": 1.0, "sound_speed": 10.0}}
    plain["fluid"] = [{"low": [0.0, 0.0], "high": [2.0, 0.5], "velocity": [0.5, 0.0]}]
    (*_, last) = ecume.simulate(from_plain(plain))
    x, y = last.arrays["position"].T
    assert [y[abs(x - place) < 0.2].max() for place in (0.5, 1.0, 1.5)] == pytest.approx([0.45] * 3, abs=0.03)
    assert last.arrays["velocity"][:, 0].mean() == pytest.approx(0.5, abs=0.02)


@pytest.mark.compiled
def test_who_falls_out_of_an_open_tank_is_lost_and_counted():
    plain = to_plain(tank(jitter=0.0))
    plain["tank"] |= {"bottom": OPEN, "low": [0.0, 0.5]}
    plain["fluid"] = [{"low": [0.0, 0.5], "high": [1.0, 1.0]}]
    frames = list(ecume.simulate(from_plain({**plain, "duration": 2.0})))
    last = frames[-1]
    assert last.numbers["particles_lost"] > 0
    assert len(last.arrays["position"]) + last.numbers["particles_lost"] == len(frames[0].arrays["position"])
    assert last.arrays["position"][:, 1].min() > 0.5 - np.hypot(1.0, 1.5) - 0.1


@pytest.mark.parametrize(
    ("side", "said"),
    [
        ({"kind": "inflow"}, "tank.left.speed"),
        ({"kind": "wall", "speed": 1.0}, "tank.left.speed"),
        ({"kind": "wall", "level": 1.0}, "tank.left.level"),
        ({"kind": "inflow", "speed": 1.0, "pressure": 1.0}, "tank.left.pressure"),
    ],
)
def test_a_side_that_cannot_be_says_why(side, said):
    plain = to_plain(channel())
    plain["tank"]["left"] = side
    with pytest.raises(SceneError) as caught:
        from_plain(plain)
    assert said in str(caught.value)


def test_the_transport_velocity_is_for_closed_flows():
    with pytest.raises(SceneError, match="closed flows"):
        SPH.parameters(channel(method={"pressure_force": "transport"}))


@pytest.mark.compiled
def test_a_channel_that_starts_from_rest_lets_out_what_comes_in():
    """What stands behind the outflow moves with the liquid, and does not block it (28 % more particles)."""
    plain = to_plain(channel(duration=2.0, gravity=[0.0, -9.81], liquid={"maximum_speed": 2.0}))
    plain["tank"] |= {"high": [2.0, 0.5]}
    plain["tank"]["left"] |= {"speed": 0.5, "profile": "uniform"}
    plain["fluid"] = [{"low": [0.0, 0.0], "high": [2.0, 0.5]}]
    first, *_, last = ecume.simulate(from_plain(plain))
    assert len(last.arrays["mass"]) == pytest.approx(len(first.arrays["mass"]), abs=4)
    assert last.arrays["velocity"][:, 0].mean() == pytest.approx(0.5, abs=0.1)
    assert last.numbers["particles_left"] == pytest.approx(50, abs=4)


@pytest.mark.compiled
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_an_outflow_in_the_floor_lets_all_liquid_fall_out(seed):
    """Without a level its pressure is that at the floor, however high the tank: the liquid falls freely. Once all has
    left, frames are empty.
    """
    dice = np.random.default_rng(seed)
    low, depth, room = dice.uniform(-1.0, 1.0), dice.uniform(0.15, 0.25), dice.uniform(0.1, 2.0)
    plain = {
        "model": "sph", "duration": 0.4, "frame_every": 0.05, "spacing": 0.025, "liquid": {"maximum_speed": 4.0},
        "tank": {
            "low": [0.0, low], "high": [0.3, low + depth + room], "bottom": {"kind": "outflow"},
            "top": {"kind": "open"},
        },
        "fluid": [{"low": [0.0, low], "high": [0.3, low + depth]}],
    }  # fmt: skip
    frames = list(ecume.simulate(from_plain(plain)))
    assert frames[1].arrays["velocity"][:, 1].mean() == pytest.approx(-9.81 * 0.05, rel=0.15)
    assert len(frames[-1].arrays["mass"]) == 0
    assert frames[-1].numbers["largest_speed"] == frames[-1].numbers["front"] == 0.0
    assert frames[-1].numbers["particles_lost"] == 0.0
