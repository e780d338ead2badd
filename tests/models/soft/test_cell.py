"""The periodic box of soft spheres: its effect on positions, velocities and the strain."""

import numpy as np
import pytest

from ecume.models.soft.cell import (
    HEIGHT,
    STRAIN,
    TILT,
    WIDTH,
    StageTarget,
    box_of,
    deform_positions,
    end_cell,
    make_cell,
)
from ecume.models.soft.protocol import drive_at
from ecume.models.soft.record import SOFT
from ecume.models.soft.report.observation import velocity_at_home
from ecume.scenes.schema import from_plain

SIDES = np.array([2.0, 3.0, 5.0])
OLD, NEW = np.array([0.1, 0.02, -0.03, 0.05, 0.4]), np.array([0.3, 0.05, 0.04, -0.02, 0.6])


def corners(shape):
    """The edges of a box, as the columns of a matrix."""
    box = box_of(SIDES, shape, 3)
    matrix = np.diag(box.sides)
    matrix[0, 1] = box.tilt
    return matrix


@pytest.mark.parametrize("dimensions", [2, 3])
def test_places_keep_their_fractions_of_the_edges(dimensions):
    cell = make_cell(SIDES, NEW, np.zeros(5), 1)
    position = np.random.default_rng(3).uniform(-1.0, 4.0, (7, dimensions))
    fractions = np.linalg.solve(corners(OLD)[:dimensions, :dimensions], position.T)
    expected = (corners(NEW)[:dimensions, :dimensions] @ fractions).T
    before, moved = position.copy(), np.zeros_like(position)
    deform_positions(cell, OLD, position, moved)
    np.testing.assert_allclose(position, expected, rtol=1e-12)
    np.testing.assert_allclose(moved, expected - before, rtol=1e-9, atol=1e-15)


def test_the_strain_that_answers_to_a_stress_is_what_the_tilt_says():
    """Per height, as the box stands at the end of the stage."""
    cell = make_cell(SIDES, NEW, np.zeros(5), 1)
    cell.rules[0] = 1
    cell.start[:5] = OLD
    drive = drive_at(SOFT.parameters(sheared(0.0)).protocol, 0.0)
    end_cell(cell, StageTarget(drive, drive, 0.5, 0.0), 0)
    height_over_width = SIDES[1] / SIDES[0] * np.exp(NEW[HEIGHT] - NEW[WIDTH])
    assert cell.shape[STRAIN] - OLD[STRAIN] == pytest.approx((NEW[TILT] - OLD[TILT]) / height_over_width)
    assert cell.slope[0, STRAIN] == pytest.approx((cell.shape[STRAIN] - OLD[STRAIN]) / 0.5)


def sheared(strain):
    return from_plain(
        {
            "model": "soft", "duration": 1.0, "frame_every": 1.0, "liquid": {"viscosity": 1e-3},
            "particles": [{"radius": 1.0, "modulus": 1.0, "positions": [[1.0, 1.0], [4.0, 3.0]]}],
            "cell": {"size": [6.0, 5.0]}, "protocol": [{"time": 0.0}, {"time": 1.0, "strain": strain}],
        }
    )  # fmt: skip


def test_the_copy_in_the_box_moves_as_the_box_carries_its_images():
    """The difference of two instants of a box that grows and shears: the home of a place moves with the edges."""
    parameters = SOFT.parameters(sheared(0.1))
    state = SOFT.start(sheared(0.1), parameters)
    shape, rate, instant = np.array([0.2, 0.05, -0.04, 0.0, 0.2]), np.array([0.3, 0.2, 0.1, 0.0, 0.3]), 1e-6
    state.cell[:], state.cell_rate[:] = shape, rate
    state.position[:] = [[13.5, 6.5], [-2.0, -4.0]]
    state.velocity[:] = [[0.4, 0.1], [0.0, -0.2]]
    homes = []
    for time in (-0.5 * instant, 0.5 * instant):
        box = box_of(parameters.box, shape + time * rate, 2)
        place = state.position + time * state.velocity
        up = np.floor(place[:, 1] / box.sides[1])
        along = np.floor((place[:, 0] - box.tilt * place[:, 1] / box.sides[1]) / box.sides[0])
        homes.append(place - np.stack([along * box.sides[0] + up * box.tilt, up * box.sides[1]], axis=1))
    assert np.abs(homes[0] - state.position).min() > 1.0
    found = velocity_at_home(parameters, state, box_of(parameters.box, shape, 2))
    np.testing.assert_allclose(found, (homes[1] - homes[0]) / instant, rtol=1e-6)
