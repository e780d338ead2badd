"""Linear systems of a step: all solvers agree, and the one with the fewest operations is chosen."""

import sys

import numpy as np
import pytest

from ecume.engine.linear_solvers import solvers
from ecume.errors import SceneError
from ecume.models.soft import SOFT
from ecume.models.soft.contacts.films import contact_response
from ecume.models.soft.integration import linear_solvers
from ecume.models.soft.integration.dirk import begin_stage, first_stage
from ecume.models.soft.integration.dirk_schemes import SCHEMES
from ecume.models.soft.integration.linear_solvers import ITERATIONS, solver_names
from ecume.models.soft.integration.newton import assemble_jacobian, imbalance
from ecume.models.soft.protocol import drive_at
from ecume.models.soft.state import FAILED
from tests.models import begun

from .clusters import integrated
from .test_packings import packing, solved_by

pytestmark = pytest.mark.compiled


def stage(scene, span):
    """The system of the first Newton step of a stage, as a matrix and the residual forces."""
    parameters, _, scratch = begun(scene)
    step = scratch.step
    first_stage(parameters.contacts, step, drive_at(parameters.protocol, 0.0))
    begin_stage(step, SCHEMES["tr-bdf2"].tableau, 1, span)
    step.bodies.position[:] += 1e-4 * np.random.default_rng(1).normal(size=step.bodies.position.shape)
    contact_response(parameters.contacts, step.pairs, step.films, step.bodies.position, span, step.responses)
    imbalance(step, 1.0, span, True)
    assemble_jacobian(step, span)
    return step.matrix, step.borders.right[:1]


@pytest.mark.parametrize("rotation", [False, True])
@pytest.mark.parametrize(("dimensions", "filled"), [pytest.param(2, 0.8, marks=pytest.mark.long), (3, 0.5)])
@pytest.mark.parametrize("name", ["iterative", "direct", "cholmod"])
def test_every_solver_gives_the_velocities_that_elimination_gives(name, dimensions, filled, rotation):
    if name == "cholmod":
        pytest.importorskip("cvxopt")
    drag = {"drag": "stokes"}
    matrix, right = stage(packing(dimensions, 20, filled, rotation=rotation, hydrodynamics=drag), 0.3)
    wanted, found = np.zeros((2, *right.shape))
    kept = solvers.Kept(matrix.pattern, right.shape[2], dimensions, accuracy=1e-13)
    assert solvers.SOLVERS["dense"](kept, matrix, right, wanted, 0)
    assert solvers.SOLVERS[name](kept, matrix, right, found, 0)
    assert np.abs(found - wanted).max() < 1e-10 * np.abs(wanted).max()


def test_the_solver_is_the_one_that_does_less_and_gradients_are_tried_again_after_a_while(monkeypatch):
    monkeypatch.setattr(solvers, "FEW", 0)
    parameters, state, scratch = begun(packing(count=40))
    direct = solvers.DENSER * solvers.work(scratch.kept)
    even = int(direct / solvers.operations_of_iteration(scratch.kept))
    for iterations, wanted in ((0, "iterative"), (even, "iterative"), (even + 1, "direct"), (2000, "direct")):
        state.effort[:] = iterations, 0, 0
        assert solver_names(parameters, scratch.kept, state.effort)[0] == wanted
    state.effort[:] = 2000, linear_solvers.AGAIN, 0
    assert solver_names(parameters, scratch.kept, state.effort) == ("iterative",)


def test_few_spheres_are_eliminated_and_a_solver_that_is_named_is_the_first_one():
    named = solved_by(packing(count=40), "iterative")
    for scene, failed, wanted in (
        (packing(count=12), 9, ("dense",)),
        (named, 0, ("iterative",)),
        (named, linear_solvers.PATIENCE, ("iterative", "direct")),
        (solved_by(packing(count=40), "direct"), 9, ("direct",)),
    ):
        parameters, state, scratch = begun(scene)
        state.effort[:] = 2000, 0, failed
        assert solver_names(parameters, scratch.kept, state.effort) == wanted


def test_a_factorization_that_would_take_too_long_never_stands_in(monkeypatch):
    parameters, state, scratch = begun(packing(count=40))
    state.effort[:] = 2000, 0, 9
    assert solver_names(parameters, scratch.kept, state.effort) == ("direct", "iterative")
    state.effort[:] = 1, 0, 9
    assert solver_names(parameters, scratch.kept, state.effort) == ("iterative", "direct")
    monkeypatch.setattr(solvers, "MOST_WORK", 1.0)
    assert solver_names(parameters, scratch.kept, state.effort) == ("iterative",)


def test_a_factorization_stands_in_where_gradients_give_up_however_short_the_step(monkeypatch):
    monkeypatch.setattr(solvers, "MOST_ITERATIONS", 1)
    scene = packing(count=30, strain=1e-3, duration=0.2)
    auto = integrated(scene)[1]
    assert auto.tally[FAILED] >= linear_solvers.PATIENCE
    assert auto.position == pytest.approx(integrated(solved_by(scene, "direct"))[1].position, abs=1e-6)


def test_many_spheres_move_alike_with_fewer_iterations_of_less_accurate_systems(monkeypatch):
    """The same positions to the tolerance of a stage, from fewer digits of each system."""
    scene, counted = solved_by(packing(count=40, strain=1e-2, duration=0.5), "iterative"), solvers.iteratively
    iterations = []

    def watched(kept, *given):
        before = kept.iterations
        solved = counted(kept, *given)
        iterations[-1] += kept.iterations - before
        return solved

    monkeypatch.setitem(solvers.SOLVERS, "iterative", watched)
    ends = []
    for many in (10**9, 1):
        monkeypatch.setattr(solvers, "MANY", many)
        iterations.append(0)
        ends.append(integrated(scene)[1].position)
    assert iterations[1] < 0.9 * iterations[0]
    assert np.abs(ends[1] - ends[0]).max() < 1e-9 * np.abs(ends[0]).max()


@pytest.mark.long
def test_interruptions_change_no_bit_while_solvers_take_turns(monkeypatch):
    monkeypatch.setattr(solvers, "DENSER", 0.0)
    monkeypatch.setattr(solvers, "FEW", 0)
    monkeypatch.setattr(linear_solvers, "AGAIN", 3)
    tried, directly = [], solvers.directly
    monkeypatch.setitem(solvers.SOLVERS, "direct", lambda *given: tried.append(given[0]) or directly(*given))
    scene = packing(count=25, strain=0.1, duration=10.0, frame_every=1.0)
    whole, pieces = integrated(scene, parts=10**9)[1], integrated(scene, parts=1)[1]
    assert tried
    assert whole.effort[ITERATIONS] > 0
    for name, array in whole._asdict().items():
        assert getattr(pieces, name).tobytes() == array.tobytes(), name


def test_a_scene_says_where_to_get_the_optional_solver(monkeypatch):
    monkeypatch.setitem(sys.modules, "cvxopt", None)
    with pytest.raises(SceneError, match=r"integration\.solver: .*GNU GPL: pip install 'cvxopt"):
        SOFT.parameters(solved_by(packing(), "cholmod"))
