import hashlib

import numpy as np
import pytest

from ecume import _jit
from ecume.models import MODELS
from ecume.simulation import moments, simulate
from tests.models.floating.bowls import HEAVY, WATER, bowl, scene_of

FLOATING = MODELS["floating"]


@pytest.mark.long
@pytest.mark.compiled
@pytest.mark.parametrize(
    ("viscosity", "radius", "seed", "duration"),
    [("2 mPa*s", "3 cm", 1, 100.0), pytest.param("0.2 Pa*s", "2.2 cm", 5, 600.0, marks=pytest.mark.long)],
)
def test_sixty_cereals_come_to_rest_and_no_energy_was_created(viscosity, radius, seed, duration):
    # Ten minutes of milk are among the long validations.
    scene = bowl(60, viscosity=viscosity, radius=radius, seed=seed, duration=duration, frame_every=0.5)
    frames = list(simulate(scene))
    energies = np.array([frame.numbers["total_energy"] for frame in frames])
    rises = np.diff(energies)
    last = frames[-1].numbers
    assert np.all(np.isfinite(frames[-1].arrays["position"]))
    assert last["deepest_overlap"] < 1e-3 * 1.5e-3
    assert np.sum(rises[rises > 0]) < 1e-6 * abs(energies[-1])
    assert last["largest_speed"] < 1e-6
    assert last["clusters"] == 1
    assert last["unconverged_steps"] == 0


def digest(state):
    return hashlib.sha256(b"".join(np.ascontiguousarray(array).tobytes() for array in state)).hexdigest()


def end_of(scene, **how):
    moment = None
    for moment in moments(scene, **how):  # noqa: B007  # the last one counts
        pass
    return digest(moment.state)


@pytest.mark.compiled
def test_interruptions_change_no_bit():
    scene = bowl(40, duration=1.0, frame_every=0.25)
    assert end_of(scene, patience=1e-5) == end_of(scene, patience=10.0)


@pytest.mark.compiled
def test_a_large_raft_has_the_same_bits_for_any_number_of_threads():
    scene = scene_of(f"{WATER}[[particles]]\ncount = 2100\n{HEAVY}", duration=0.02, frame_every=0.02)
    ends = []
    for threads in (1, 2):
        _jit.use_threads(threads)
        ends.append(end_of(scene))
    assert ends[0] == ends[1]


@pytest.mark.compiled
def test_floats_that_outgrow_their_workspace_get_a_larger_one_and_the_same_bits():
    scene = bowl(60, duration=1.0, frame_every=0.5)
    parameters = FLOATING.parameters(scene)
    state = FLOATING.start(scene, parameters)
    tight = FLOATING.workspace(parameters, state, 0.05)
    steps = 2 * parameters.steps_per_frame
    while state.step[0] < steps:
        FLOATING.advance(parameters, state, tight, steps - int(state.step[0]))
        tight = FLOATING.workspace(parameters, state, 0.05)
    assert digest(state) == end_of(scene)


@pytest.mark.long
@pytest.mark.compiled
def test_contacts_of_a_settled_raft_carry_the_pull_and_nothing_moves():
    scene = bowl(19, radius="1.2 cm", duration=120.0, frame_every=10.0)
    frames = list(simulate(scene))
    before, after = frames[-2].arrays["position"], frames[-1].arrays["position"]
    assert np.max(np.abs(after - before)) < 1e-9
    assert frames[-1].numbers["clusters"] == 1


@pytest.mark.long
@pytest.mark.compiled
@pytest.mark.parametrize(
    ("of_floats", "of_wall"),
    [(0.9, 0.1), *(pytest.param(*both, marks=pytest.mark.long) for both in ((0.2, 0.2), (0.5, 1.0)))],
)
def test_rafts_at_a_wall_do_not_rattle_and_mixed_restitutions_create_no_energy(of_floats, of_wall):
    scene = scene_of(
        '[liquid]\ndensity = 1030.0\nviscosity = "2 mPa*s"\nsurface_tension = "45 mN/m"\n'
        '[[particles]]\ncount = 60\nradius = "1.5 mm"\ndensity = 300.0\ncontact_angle = "70 deg"\n'
        f'[dish]\nradius = "4 cm"\ncontact_angle = "75 deg"\nrestitution = {of_wall}\n'
        f"[contacts]\nrestitution = {of_floats}\n",
        duration=40.0,
        frame_every=0.25,
        head="seed = 1",
    )
    frames = list(simulate(scene))
    energies = np.array([frame.numbers["total_energy"] for frame in frames])
    rises = np.diff(energies)
    collisions = [frame.numbers["collisions"] for frame in frames]
    assert np.sum(rises[rises > 0]) < 1e-6 * abs(energies[-1])
    # Rattling floats would collide thousands of times a second; these only meet when rafts do.
    assert collisions[-1] - collisions[len(frames) // 2] < 500
