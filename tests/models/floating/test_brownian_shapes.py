"""Brownian motion of floats with a shape: along themselves, across and around, between walls, and its heat."""

import math

import numpy as np
import pytest

from ecume.models.floating import FLOATING
from ecume.models.floating.parameters import WORK
from ecume.models.floating.shaped.bodies import shaped_energies
from ecume.models.floating.shaped.constants import inner_radius
from ecume.models.floating.shaped.shapes import Skeleton
from ecume.models.floating.time_integration.step_size import GOOD
from tests.models.floating.bowls import scene_of

pytestmark = pytest.mark.filterwarnings("ignore:overflow encountered")  # philox, by design
RADIUS, WIDTH = 2e-6, 2e-6
WATER = "[liquid]\ndensity = 1000.0\nviscosity = 1e-3\nsurface_tension = 0.0728\n"
NOISE = '[integration]\nintegrator = "overdamped"\n[hydrodynamics]\nbrownian = true\n'
FREE = f'{NOISE}[interaction]\nlaw = "none"\n'


def ellipsoids(places, angle=0.0, density=1000.0, radius=RADIUS, width=WIDTH):
    return (
        f"[[particles]]\nradius = {radius}\ndensity = {density}\ncontact_angle = 1.5707963\n"
        f'shape = {{ kind = "ellipsoid", width = {width}, angle = {angle} }}\npositions = {places}\n'
    )


def begun(text, duration=1.0):
    scene = scene_of(WATER + text, duration=duration, frame_every=duration)
    parameters = FLOATING.parameters(scene)
    state = FLOATING.start(scene, parameters)
    return parameters, state, FLOATING.workspace(parameters, state, 1.0)


def test_displacements_have_the_variances_of_the_three_frictions():
    count, angle, steps = 200, 0.7, 4
    places = [[1e-5 * (k % 15), 1e-5 * (k // 15)] for k in range(count)]
    parameters, state, workspace = begun(ellipsoids(places, angle) + FREE)
    assert 2.0 * parameters.drift.thermal * parameters.time_step <= (GOOD * 0.5 * WIDTH) ** 2 * (
        parameters.parts.integrator.friction[:, :2].min() * 1.001
    )
    found = []
    for _ in range(steps):
        place, turn = state.position.copy(), state.turning[:, 0].copy()
        FLOATING.advance(parameters, state, workspace, 1)
        x, y = (state.position - place).T
        c, s = np.cos(turn), np.sin(turn)
        found.append([c * x + s * y, c * y - s * x, state.turning[:, 0] - turn])
    variance = np.mean(np.square(found), axis=(0, 2))
    exact = 2.0 * parameters.drift.thermal / parameters.parts.integrator.friction[0] * parameters.time_step
    # Four standard errors of a variance.
    assert variance == pytest.approx(exact, rel=4.0 * math.sqrt(2.0 / (steps * count)))
    assert exact[0] > 1.05 * exact[1]


@pytest.mark.compiled  # 24,000 steps
def test_an_ellipsoid_between_walls_is_wherever_there_is_room():
    """The share of an angle is proportional to the area that its outline leaves free."""
    width, height, steps = 2.5 * RADIUS, 2.3 * RADIUS, 24_000
    dish = f'[dish]\nsize = [{width}, {height}]\ncontact_angle = 1.5707963267948966\nlaw = "none"\nrestitution = 0.0\n'
    parameters, state, workspace = begun(ellipsoids([[0.0, 0.0]], 0.3) + dish + FREE, duration=1e3)
    angle, wall = [], []
    for _ in range(steps // 4):
        FLOATING.advance(parameters, state, workspace, 4)
        turn, (x, y) = state.turning[0, 0], state.position[0]
        angle.append(turn)
        along, across = extents(turn)
        wall.append(min(0.5 * width - abs(x) - along, 0.5 * height - abs(y) - across))
    assert min(wall) > -2e-4 * RADIUS
    turns = np.linspace(0.0, math.pi, 2001)[:-1]
    along, across = extents(turns)
    free = np.maximum(width - 2.0 * along, 0.0) * np.maximum(height - 2.0 * across, 0.0)
    for mode in (2.0, 4.0):
        exact = float(np.average(np.cos(mode * turns), weights=free))
        blocks = np.cos(mode * np.array(angle)).reshape(20, -1).mean(axis=1)
        assert blocks.mean() == pytest.approx(exact, abs=4.0 * blocks.std() / math.sqrt(20))
    near = 0.005 * RADIUS
    inside = np.maximum(width - 2.0 * (along + near), 0.0) * np.maximum(height - 2.0 * (across + near), 0.0)
    exact, blocks = 1.0 - inside.sum() / free.sum(), (np.array(wall) < near).reshape(20, -1).mean(axis=1)
    assert blocks.mean() == pytest.approx(exact, abs=4.0 * blocks.std() / math.sqrt(20))


def extents(turn):
    """Half the extents along x and y of the ellipse."""
    c, s = np.square(np.cos(turn)), np.square(np.sin(turn))
    a, b = RADIUS**2, (0.5 * WIDTH) ** 2
    return np.sqrt(a * c + b * s), np.sqrt(a * s + b * c)


def test_the_energy_of_bound_ellipsoids_changes_by_the_heat():
    """Heavy enough to be bound by thousands of kT; contacts do no work."""
    radius = 30e-6
    text = ellipsoids([[-radius, 0.0], [1.15 * radius, 0.0]], 0.4, 2500.0, radius, 0.9 * radius) + NOISE
    parameters, state, workspace = begun(text, duration=1e3)

    def energy():
        part, scratch = parameters.parts.interactions[0], workspace.scratch.interactions[0]
        return shaped_energies(part, scratch, parameters, state, workspace)[0]

    first = energy()
    FLOATING.advance(parameters, state, workspace, 150)
    change = energy() - first
    assert abs(change) > 20.0 * parameters.drift.thermal
    assert state.tally[WORK] == pytest.approx(change, rel=0.02)


def test_the_inner_radius_is_that_of_the_narrowest_place():
    assert inner_radius(Skeleton(axes=(3.0, 1.0))) == pytest.approx(1.0)
    needle = Skeleton((0.0, 0.0), ((-2.0, 0.0), (2.0, 0.0)), ((0, 1),), 0.5)
    assert inner_radius(needle) == pytest.approx(0.5)
