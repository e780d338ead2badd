"""Spheres that rotate: common rotations cause no forces, and torques balance."""

import dataclasses
import math

import numpy as np
import pytest

from ecume.errors import BadInput, SceneError
from ecume.models.soft import SOFT, t1_process
from ecume.models.soft.contacts.films import contact_response
from ecume.models.soft.contacts.rotation import carry, remove_free_rotation, turn_pairs, turned_orientation
from ecume.models.soft.integration.dirk import first_stage
from ecume.models.soft.integration.newton import assemble_jacobian, imbalance
from ecume.models.soft.protocol import drive_at
from ecume.scenes.schema import from_plain
from ecume.simulation import simulate

from .clusters import integrated

pytestmark = pytest.mark.sampled(2)

PLACES = {2: [[0.0, 0.0], [2.13, 0.1], [0.9, 2.1]], 3: [[0.0, 0.0, 0.0], [2.1, 0.1, 0.2], [0.9, 2.1, -0.1]]}
RADII = (1.0, 1.1, 0.9)
STERIC = {"law": "steric", "steric_strength": 0.03, "steric_length": 0.3}


def cluster(dimensions=2, places=None, rotation=True, drag=False, **more):
    """Three different spheres, all connected with each other."""
    places = PLACES[dimensions] if places is None else places
    plain = {
        "model": "soft", "duration": 10.0, "frame_every": 10.0, "rotation": rotation,
        "liquid": {"viscosity": 0.1},
        "hydrodynamics": {"drag": "stokes" if drag else "none"}, "integration": {"tolerance": 1e-8},
        "particles": [{"radius": r, "modulus": 1.0 + r, "positions": [p]} for r, p in zip(RADII, places, strict=False)],
    }  # fmt: skip
    return from_plain(plain | more)


def at_work(scene):
    parameters = SOFT.parameters(scene)
    state = SOFT.start(scene, parameters)
    step = SOFT.workspace(parameters, state, 1.0).step
    first_stage(parameters.contacts, step, drive_at(parameters.protocol, 0.0))
    return parameters, step


@pytest.mark.parametrize("torque", [[0.3], [0.3, -0.2, 0.5]])
def test_a_sphere_alone_starts_with_the_spin_that_stokes_says(torque):
    places = [[0.0, 0.0, 0.0], [50.0, 0.0, 0.0]] if len(torque) == 3 else [[0.0, 0.0], [50.0, 0.0]]
    spheres = [{"radius": 1.2, "modulus": 1.0, "positions": [place], "torque": torque} for place in places]
    parameters, step = at_work(cluster(particles=spheres, films={"cutoff": 1.0}, drag=True))
    radius = parameters.radius[0]
    spin = np.array(torque) / (8.0 * math.pi * 0.1 * radius**3)
    assert step.spins.slope[0, 0] == pytest.approx(radius * spin, rel=1e-12)


def rebalance(parameters, step, span):
    """Solve the contacts over a span at held spheres."""
    turn_pairs(step.pairs, step.spins.turn)
    for _ in range(40):
        contact_response(parameters.contacts, step.pairs, step.films, step.bodies.position, span, step.responses)
        step.films.log_gap[:] += step.responses.shift[:, 0]
        step.films.direction[:] += step.responses.shift[:, 1:]
        step.films.direction[:] /= np.linalg.norm(step.films.direction, axis=1)[:, None]
    assert np.abs(step.responses.shift).max() < 1e-12


def rotation(angle, dimensions):
    """About z, or about an oblique axis in space; and the axis times the angle."""
    axis = np.array([0.0, 0.0, 1.0]) if dimensions == 2 else np.array([0.48, -0.6, 0.64])
    across = np.cross(np.eye(3), axis)
    turn = np.eye(3) + across * math.sin(angle) + (1 - math.cos(angle)) * across @ across
    return turn[:dimensions, :dimensions], (angle * axis)[-1:] if dimensions == 2 else angle * axis


@pytest.mark.parametrize("dimensions", [2, 3])
@pytest.mark.parametrize("span", [0.0, 0.3])
def test_newtons_matrix_is_the_slope_of_forces_and_torques(dimensions, span):
    parameters, step = at_work(cluster(dimensions, drag=True))
    random = np.random.default_rng(3)
    step.bodies.position[:] += 0.02 * random.normal(size=step.bodies.position.shape)
    step.spins.turn[:] = 0.01 * random.normal(size=step.spins.turn.shape)
    place, turn = step.bodies.position.copy(), step.spins.turn.copy()

    def left(change):
        step.bodies.position[:] = place + change[:, :dimensions]
        step.bodies.moved[:] = step.bodies.position - step.bodies.before
        step.spins.turn[:] = turn + change[:, dimensions:]
        rebalance(parameters, step, span)
        imbalance(step, 1.0, span or 1e300, False)
        return step.bodies.right.copy()

    width = step.bodies.right.shape[1]
    left(np.zeros((3, width)))
    assemble_jacobian(step, span)
    matrix, pattern = np.zeros((3 * width, 3 * width)), step.matrix.pattern
    for i in range(3):
        for block in range(pattern.start[i], pattern.start[i + 1]):
            j = pattern.column[block]
            matrix[i * width : (i + 1) * width, j * width : (j + 1) * width] = step.matrix.blocks[block]
    for k in range(3 * width):
        change = np.zeros(3 * width)
        change[k] = 1e-6
        slope = (left(-change.reshape(3, width)) - left(change.reshape(3, width))) / 2e-6
        # In space a spin adds to a turn by a turn that is slightly another: by half the turn so far.
        most = 2e-8 if dimensions == 2 or k % width < 3 else 0.02 * np.abs(matrix).max()
        assert slope.ravel() == pytest.approx(matrix[:, k], rel=2e-6, abs=most)


@pytest.mark.parametrize("dimensions", [2, 3])
def test_forces_and_moments_of_contacts_sum_to_zero(dimensions):
    parameters, step = at_work(cluster(dimensions))
    random = np.random.default_rng(5)
    step.bodies.position[:] += 0.03 * random.normal(size=step.bodies.position.shape)
    step.spins.turn[:] = 0.05 * random.normal(size=step.spins.turn.shape)
    rebalance(parameters, step, 0.2)
    _, largest, _ = imbalance(step, 1.0, 0.2, False)
    force, torque = np.split(step.bodies.right, [dimensions], axis=1)
    assert largest > 1e-3
    assert np.abs(torque).max() > 1e-4
    assert force.sum(axis=0) == pytest.approx(np.zeros(dimensions), abs=1e-15)
    arm, pull = np.zeros((2, 3, 3))
    arm[:, :dimensions], pull[:, :dimensions] = step.bodies.position, force
    moment = np.cross(arm, pull).sum(axis=0)[-torque.shape[1] :] + parameters.radius @ torque
    assert moment == pytest.approx(np.zeros_like(moment), abs=1e-15)


@pytest.mark.long
@pytest.mark.parametrize("dimensions", [2, pytest.param(3, marks=pytest.mark.compiled)])
@pytest.mark.parametrize("remote", [{}, pytest.param(STERIC, marks=pytest.mark.compiled)], ids=["relaxing", "steric"])
def test_a_cluster_that_turns_as_a_whole_feels_what_it_feels_at_rest(dimensions, remote):
    (parameters, still_step), (_, step) = (at_work(cluster(dimensions, long_range_forces=remote)) for _ in range(2))
    turn, angle = rotation(0.37, dimensions)
    whole, span = np.eye(dimensions), 0.4
    place = 1.001 * step.bodies.position.copy()
    still_step.bodies.position[:] = place
    for _ in range(60):  # three and a half turns
        whole = turn @ whole
        step.bodies.position[:] = place @ whole.T
        step.spins.turn[:] = np.array(RADII)[:, None] * angle
        for one in (still_step, step):
            rebalance(parameters, one, span)
            carry(one.pairs.turn, one.films.direction)
            one.films.log_gap_start[:], one.films.direction_start[:] = one.films.log_gap, one.films.direction
        expected = still_step.responses.force[:, :dimensions] @ whole.T
        assert step.responses.force[:, :dimensions] == pytest.approx(expected, abs=1e-13)
    assert np.linalg.norm(expected, axis=1).max() > (0.05 if remote else 1e-4)
    assert step.films.log_gap == pytest.approx(still_step.films.log_gap, abs=1e-12)


@pytest.mark.long
@pytest.mark.compiled
@pytest.mark.parametrize(("gap", "kappa"), [(1e-2, 1e-3), (0.1, 1e-6), (1e-3, 1e-4), (1e-5, 1e-2)])
def test_spheres_do_not_spin_in_a_symmetric_swap(gap, kappa):
    free, spun = (t1_process(gap=gap, reduced_force=kappa, rotation=switch) for switch in (False, True))
    assert spun.turned < 1e-14
    assert spun.duration == pytest.approx(free.duration, rel=1e-9)


@pytest.mark.compiled
def test_gears_turn_against_each_other_and_what_turns_alike_drags_its_neighbor():
    def spins(*torques):
        spheres = [
            {"radius": r, "modulus": 10.0, "positions": [[x, 0.0]], "torque": [t]}
            for r, x, t in zip((1.0, 1.5), (0.0, 2.52), torques, strict=True)
        ]
        plain = {
            "model": "soft", "duration": 3.0, "frame_every": 3.0, "rotation": True,
            "liquid": {"viscosity": 0.1}, "hydrodynamics": {"drag": "stokes"}, "particles": spheres,
        }  # fmt: skip
        return integrated(from_plain(plain))[1]

    # Equal speeds of the equators: the film between is not sheared, and each spins as if it were alone.
    alone = 8 * math.pi * 0.1
    gears = spins(1e-3 * alone, -1e-3 / 1.5 * 1.5**3 * alone)
    assert gears.spin[:, 0] == pytest.approx([1e-3, -1e-3 / 1.5], rel=1e-9)
    assert np.abs(gears.velocity).max() < 1e-15
    one = spins(1e-3 * alone, 0.0)
    assert 0.0 < one.spin[0, 0] < 0.95e-3
    assert one.spin[1, 0] < 0.0
    # What turns counterclockwise climbs its neighbor downwards, and pushes that up.
    assert one.velocity[0, 1] < 0.0 < one.velocity[1, 1]


def sheared(dimensions=2, solver="auto", strain=0.02):
    volume = sum(10 * (math.pi * r**2 if dimensions == 2 else 4 / 3 * math.pi * r**3) for r in (1.0, 1.3))
    return from_plain({
        "model": "soft", "duration": 2.0, "frame_every": 1.0, "rotation": True, "liquid": {"viscosity": 1e-3},
        "particles": [{"radius": r, "modulus": 1.0, "count": 10} for r in (1.0, 1.3)],
        "cell": {"size": [(volume / (0.75 if dimensions == 2 else 0.5)) ** (1 / dimensions)] * dimensions,
            "minimum_gap": 0.02},
        "protocol": [{"time": 0.0}, {"time": 2.0, "strain": strain}],
        "integration": {"integrator": "tr-bdf2", "tolerance": 1e-4, "solver": solver},
    })  # fmt: skip


@pytest.mark.compiled
@pytest.mark.parametrize("dimensions", [2, 3])
def test_every_solver_finds_the_same_spins_and_shear_turns_spheres_by_half(dimensions):
    ends = [integrated(sheared(dimensions, solver))[1] for solver in ("dense", "iterative", "direct")]
    for end in ends[1:]:
        assert end.orientation == pytest.approx(ends[0].orientation, abs=1e-5)
    # In a homogeneous flow by half of the shear, clockwise.
    spin = ends[0].spin[:, -1].mean()
    assert spin == pytest.approx(-0.5 * 0.01, rel=0.35)


@pytest.mark.compiled
def test_interruptions_change_no_bit_of_a_spin():
    whole, pieces = integrated(sheared(strain=0.3), parts=10**9)[1], integrated(sheared(strain=0.3), parts=2)[1]
    assert np.abs(whole.orientation).max() > 0.01
    for name, array in whole._asdict().items():
        assert array.tobytes() == getattr(pieces, name).tobytes(), name


@pytest.mark.compiled
@pytest.mark.parametrize(("dimensions", "name", "width"), [(2, "angle", ()), (3, "orientation", (4,))])
def test_frames_contain_the_orientations_of_spheres(dimensions, name, width):
    frames = list(simulate(sheared(dimensions)))
    assert frames[-1].arrays[name].shape == (20, *width)
    assert np.abs(frames[-1].arrays["spin"]).max() > 1e-3
    plain = list(simulate(dataclasses.replace(sheared(dimensions), rotation=False)))
    assert "spin" not in plain[-1].arrays


def test_orientations_add_up_to_a_turn():
    quaternion = np.array([[1.0, 0.0, 0.0, 0.0]])
    for _ in range(10):
        quaternion = turned_orientation(quaternion, np.array([[0.0, 0.0, math.pi / 20]]))
    assert quaternion[0] == pytest.approx([math.cos(math.pi / 4), 0.0, 0.0, math.sin(math.pi / 4)], abs=1e-15)
    later = turned_orientation(quaternion, np.array([[math.pi / 2, 0.0, 0.0]]))
    # The later turn, about an axis at rest, stands on the left.
    assert later[0] == pytest.approx([0.5, 0.5, -0.5, 0.5], abs=1e-15)


@pytest.mark.parametrize("dimensions", [2, 3])
@pytest.mark.parametrize("loads", ["none", "of one line", "all around"])
def test_a_turn_of_all_spheres_is_taken_back_by_their_loads_or_leaves_no_mean_spin(dimensions, loads):
    _, step = at_work(cluster(dimensions))
    place = step.bodies.position
    middle = place.mean(axis=0)
    pull = 1e-3 * (place - middle)
    if loads == "of one line":
        pull = np.outer([1e-3, -1e-3, 0.0], place[0] - place[1])
    pull = pull * (loads != "none")
    changes = step.borders.change
    spins = (np.array([[0.3]]), np.array([[1.0]])) if dimensions == 2 else (np.array([[0.3, -0.2, 0.5]]), np.eye(3))
    for change, turn in zip(changes, np.concatenate(spins), strict=False):
        axis = np.array([0.0, 0.0, *turn])[-3:]
        arm = np.zeros((3, 3))
        arm[:, :dimensions] = place - middle
        change[:] = np.concatenate([np.cross(axis, arm)[:, :dimensions], np.outer(RADII, turn)], axis=1)
    remove_free_rotation(place, step.spins, changes, (pull, np.zeros_like(pull), 1.0))
    # All was one turn: it is gone, about each axis for one reason or the other.
    assert np.abs(changes[0]).max() < 1e-9


@pytest.mark.long
@pytest.mark.compiled
@pytest.mark.parametrize("dimensions", [2, 3])
@pytest.mark.parametrize("sense", [1.0, -1.0], ids=["pulled", "pressed"])
def test_unlike_spheres_that_nothing_holds_lie_where_their_loads_have_no_moment(dimensions, sense):
    # Three forces through one point, in their plane; they stay as they are while the spheres change places.
    place = np.array(PLACES[dimensions])
    out = place - (0.3 * place[0] + 0.3 * place[1] + 0.4 * place[2])
    pull = sense * 5e-3 * np.array([0.3, 0.3, 0.4])[:, None] * out
    spheres = [
        {"radius": r, "modulus": 1.0 + r, "positions": [p], "force": f}
        for r, p, f in zip(RADII, place.tolist(), pull.tolist(), strict=True)
    ]
    given = {"duration": 5.0, "frame_every": 5.0, "particles": spheres}
    ends = [
        integrated(cluster(dimensions, integration={"tolerance": 1e-6, "solver": solver}, **given))
        for solver in ("dense", "direct")
    ]
    parameters, state = ends[0]
    assert ends[1][1].position == pytest.approx(state.position, abs=1e-8)
    step = SOFT.workspace(parameters, state, 1.0).step
    first_stage(parameters.contacts, step, drive_at(parameters.protocol, 5.0))
    worst, largest, _ = imbalance(step, 1.0, 1.0, False)
    assert worst < 1e-8 * largest
    assert np.abs(state.spin).max() > 1e-6
    moved = state.position - place
    assert np.abs(moved - moved.mean(axis=0)).max() > 1e-3


@pytest.mark.parametrize(
    ("torque", "rotation", "says"),
    [
        ([1.0], False, "do not spin"),
        ([1.0, 2.0, 3.0], True, "expected 1"),
        ([1.0], True, "the total torque on all spheres"),
    ],
)
def test_torques_without_sense_are_refused(torque, rotation, says):
    spheres = [{"radius": 1.0, "modulus": 1.0, "positions": [[x, 0.0]], "torque": torque} for x in (0.0, 2.1)]

    def begin():
        scene = cluster(particles=spheres, rotation=rotation)
        SOFT.start(scene, SOFT.parameters(scene))

    with pytest.raises(SceneError, match=says):
        begin()


def test_the_papers_own_way_knows_no_spin():
    with pytest.raises(BadInput, match="rotation"):
        t1_process(gap=1e-2, reduced_force=1e-3, rotation=True, method="rk4")
