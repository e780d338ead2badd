"""Two spheres move as the closed forms say."""

import math

import numpy as np
import pytest

from ecume.errors import SceneError
from ecume.laws.soft_pair import SoftPair, passage_time
from ecume.models.model import DONE
from ecume.models.soft import SOFT
from ecume.models.soft.state import CLOCK
from ecume.scenes.load import load_scene
from ecume.scenes.schema import from_plain
from ecume.scenes.templates import copy_template
from ecume.simulation import simulate
from tests.oracles.soft_contacts import deflection_under_force, relaxation_passage

from .clusters import integrated, pull_apart

pytestmark = pytest.mark.compiled

PAIR = SoftPair(1.0, 1.0, 1.0)
FORCE_RESIDUAL = {"radius": 1.0, "modulus": 1.0, "positions": [[-1.005, 0.0]], "force": [-1e-3, 0.0]}
RIGHT = {"radius": 1.0, "modulus": 1.0, "positions": [[1.005, 0.0]], "force": [1e-3, 0.0]}
SCENE = {
    "model": "soft", "duration": 2e4, "frame_every": 2e4, "liquid": {"viscosity": 1.0},
    "integration": {"tolerance": 1e-9}, "particles": [FORCE_RESIDUAL, RIGHT],
}  # fmt: skip
DRAGGED = SCENE | {"liquid": {"viscosity": 1.0}, "hydrodynamics": {"drag": "stokes"}}


def to_the_end(parameters, state):
    work = SOFT.workspace(parameters, state, 1.0)
    while state.step[0] < parameters.steps_per_frame:
        assert SOFT.advance(parameters, state, work, parameters.steps_per_frame) == DONE
    return state


@pytest.mark.parametrize("kappa", [1e-5, 1e-3, 1e-2])
@pytest.mark.parametrize(("gap", "end"), [(1e-3, 1e-1), (1e-2, 1e-3)])
def test_a_gap_opens_and_closes_in_the_time_of_the_closed_form(kappa, gap, end):
    force = kappa if end > gap else -kappa
    time = passage_time(PAIR, force, gap, end)
    _, state = integrated(pull_apart(gap, force, duration=time))
    assert math.exp(state.log_gap[0]) == pytest.approx(end, rel=1e-6)
    gap = math.exp(state.log_gap[0])
    distance = 2 + gap + deflection_under_force(PAIR, gap, force)
    assert state.position[1, 0] - state.position[0, 0] == pytest.approx(distance, rel=1e-10)


@pytest.mark.parametrize("prefactors", ["paper", "physical"])
def test_direction_and_dimension_change_nothing(prefactors):
    ends = [
        integrated(pull_apart(0.01, 1e-3, duration=2e4, prefactors=prefactors, turn=turn, more=more))[1].log_gap[0]
        for turn, more in ((0.0, ()), (1.0, ()), (2.0, (-0.7,)), (0.3, (5.0,)))
    ]
    assert ends == pytest.approx([ends[0]] * 4, rel=1e-9)


def test_tension_relaxes_between_centers_that_are_held():
    scene = pull_apart(0.01, 1e-3, duration=relaxation_passage(PAIR, 0.05, 0.04, 0.01))
    parameters = SOFT.parameters(scene)
    state = SOFT.start(scene, parameters)
    state.position[:, 0] = -1.025, 1.025
    # So much drag that nothing moves.
    to_the_end(parameters._replace(drag=np.full(2, 1e10)), state)
    assert 0.05 - math.exp(state.log_gap[0]) == pytest.approx(0.01, rel=1e-6)


def test_a_gap_that_is_pressed_for_ever_never_closes():
    _, state = integrated(pull_apart(1e-2, -1e-2, duration=1e9, tolerance=1e-6))
    late = 1e-2 ** (2 / 3) * math.sqrt(1.5 * math.pi * 1e2 / 2e9)
    assert math.exp(state.log_gap[0]) == pytest.approx(late, rel=1e-3)


def test_steric_layers_bear_the_load_in_the_end():
    scene = pull_apart(0.05, -1e-3, duration=1e7, tolerance=1e-6)
    steric = SOFT.parameters(scene).contacts._replace(remote=1, strength=1e-3, steric_length=0.02)
    parameters = SOFT.parameters(scene)._replace(contacts=steric)
    state = to_the_end(parameters, SOFT.start(scene, parameters))
    assert math.exp(state.log_gap[0]) == pytest.approx(0.01, rel=1e-4)


def test_drag_slows_spheres_that_part_and_lets_forces_push_them_along():
    free, held = integrated(from_plain(SCENE))[1], integrated(from_plain(DRAGGED))[1]
    assert held.log_gap[0] < free.log_gap[0] - 0.01
    along = [spec | {"force": [1e-3, 0.0]} for spec in (FORCE_RESIDUAL, RIGHT)]
    pushed = integrated(from_plain(DRAGGED | {"particles": along}))[1]
    assert pushed.velocity[:, 0] == pytest.approx([1e-3 / (6 * math.pi)] * 2, rel=1e-3)


def test_interruptions_change_no_bit():
    scene = pull_apart(0.01, 1e-3, duration=2e4, frames=7)
    whole, pieces = integrated(scene, parts=10**9)[1], integrated(scene, parts=3)[1]
    for name, array in whole._asdict().items():
        assert array.tobytes() == getattr(pieces, name).tobytes(), name


def test_the_template_opens_its_gap_as_the_closed_form_says(tmp_path):
    scene = load_scene(copy_template("soft-two-spheres", tmp_path / "pair.toml")[0])
    frames = list(simulate(scene))
    pair = SoftPair(1e-3, 1e4, 10.0)
    for frame in frames[20::70]:
        assert passage_time(pair, 1e-5, 1e-5, frame.numbers["smallest_gap"]) == pytest.approx(frame.time, rel=1e-5)
        assert frame.arrays["tension"][0, 0] == pytest.approx(1e-5, rel=1e-8)
    assert frames[0].arrays["neighbor"].tolist() == [[1], [-1]]


@pytest.mark.parametrize(
    ("change", "path", "says"),
    [
        ({"particles": [FORCE_RESIDUAL]}, "particles", "single sphere"),
        ({"particles": [FORCE_RESIDUAL, RIGHT | {"positions": [[0.9, 0.0]]}]}, "particles", "overlap by 95 mm"),
        ({"particles": [FORCE_RESIDUAL, RIGHT | {"force": [0.0, 0.0]}]}, "particles", "sum to 1 mN"),
        ({"films": {"cutoff": 0.001}}, "particles", "no film to sphere 0"),
        ({"films": {"prefactors": "papr"}}, "films.prefactors", "there are paper, physical"),
        ({"long_range_forces": {"law": "magic"}}, "long_range_forces.law", "none, steric, dlvo"),
        ({"liquid": {"viscosity": 0.0}}, "liquid.viscosity", "expected 1e-12 or more"),
        ({"particles": [FORCE_RESIDUAL | {"modulus": 0.0}, RIGHT]}, "particles[0].modulus", "or more"),
        ({"protocol": [{"time": 1.0}, {"time": 0.5}]}, "protocol[1].time", "before 1 s"),
        ({"protocol": [{"time": 1.0, "strain": 0.5}]}, "protocol[0].strain", "is that of a [cell]"),
    ],
)
def test_what_cannot_be_simulated_is_refused_in_one_line(change, path, says):
    def begin():
        scene = from_plain(SCENE | change)
        SOFT.start(scene, SOFT.parameters(scene))

    with pytest.raises(SceneError) as caught:
        begin()
    (fault,) = caught.value.faults
    assert fault.path == path
    assert says in fault.message


def test_frames_come_at_their_times():
    scene = pull_apart(0.01, 1e-3, duration=2e4, frames=5, tolerance=1e-6)
    assert [frame.time for frame in simulate(scene)] == pytest.approx([0.0, 4e3, 8e3, 1.2e4, 1.6e4, 2e4], rel=1e-15)
    assert integrated(scene)[1].pace[CLOCK] == 2e4


def test_attraction_without_a_barrier_ends_at_the_smallest_separation_and_check_warns_of_it():
    scene = from_plain(
        {
            "model": "soft", "duration": "10 ms", "frame_every": "1 ms", "liquid": {"viscosity": "1 mPa*s"},
            "particles": [{"radius": "1 um", "modulus": "1 MPa", "positions": [[0.0, 0.0], ["2.01 um", 0.0]]}],
            "long_range_forces": {"law": "dlvo", "hamaker_constant": "10 zJ"},
            "integration": {"tolerance": 1e-4},
        }
    )  # fmt: skip
    last = list(simulate(scene))[-1]
    assert 0.5 * 1.65e-10 < last.numbers["smallest_gap"] < 1.65e-10
    assert any("attraction beats the double layer" in remark for _, _, remark in SOFT.summary(scene))
