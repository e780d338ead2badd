"""The figure of sizes."""

import numpy as np
import pytest

from ecume.scenes.load import load_scene
from ecume.scenes.templates import folder
from ecume.show.curves import sizes
from ecume.show.figures import FIGURES
from ecume.show.publishing import points_of, written_data
from ecume.simulation import simulate


def test_equal_sizes_are_in_the_middle_of_one_class_and_all_particles_are_counted():
    scene = load_scene(folder() / "two-spheres.toml")
    frame = next(simulate(scene))
    axes = sizes([frame], scene).axes[0]
    radius = 1e3 * float(np.mean(frame.arrays["radius"]))
    number, volume, _mean = axes.lines
    for steps in (number, volume):
        edges, heights = points_of(steps).T
        part = heights[:-1]
        full = int(np.argmax(part))
        assert part.sum() == pytest.approx(100.0) == part[full]
        assert 0.5 * (edges[full] + edges[full + 1]) == pytest.approx(radius)


def test_a_histogram_is_written_as_a_table_with_a_row_for_each_edge(tmp_path):
    scene = load_scene(folder() / "two-spheres.toml")
    drawn = sizes([next(simulate(scene))], scene)
    written_data(drawn, tmp_path / "sizes.csv")
    rows = (tmp_path / "sizes.csv").read_text().splitlines()[1:]
    assert [row.split(",")[1] for row in rows] == 6 * ["of the number"] + 6 * ["of the volume"]


def test_floats_that_are_far_apart_are_in_the_range_of_their_pair_distribution():
    lattice = [[0.02 * x, 0.02 * y] for x in range(5) for y in range(5)]  # 20 radii between neighbors
    scene = load_scene(folder() / "two-spheres.toml", [f"particles[0].positions={lattice}"])
    drawn = FIGURES["floating"]["pair-distribution"]([next(simulate(scene))], scene)
    assert points_of(drawn.axes[0].lines[0])[:, 1].max() > 0.0
