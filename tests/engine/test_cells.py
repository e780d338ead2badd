import numpy as np
import pytest

from ecume.engine.cells import make_cells, sort_into_cells


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("count", [1, 2, 300])
def test_every_particle_stands_in_its_own_cell_once_and_in_ascending_order(dimension, count):
    position = np.random.default_rng(count).random((count, dimension)) * 3.0
    cells = make_cells(count, dimension)
    sort_into_cells(cells, position, 0.2)
    total = int(np.prod(cells.shape))
    assert cells.start[0] == 0
    assert cells.start[total] == count
    for cell in range(total):
        members = cells.order[cells.start[cell] : cells.start[cell + 1]]
        assert np.all(cells.cell[members] == cell)
        assert np.all(np.diff(members) > 0)


def test_sparse_particles_get_larger_cells_rather_than_more_of_them():
    position = np.array([[0.0, 0.0], [1e6, 1e6]])
    cells = make_cells(2, 2)
    sort_into_cells(cells, position, 1e-3)
    assert np.prod(cells.shape) < len(cells.start)
    assert cells.size[0] > 1e-3
