"""Figures of a sweep show the numbers of its table."""

import numpy as np
import pytest

from ecume.errors import BadInput
from ecume.sweep.figures import edges, sweep_figure


class Made:
    """A sweep's table, made up."""

    title, directory = "Costs $5", "nowhere"
    axes = ("gap", "force", "repeat")

    def table(self):
        rows = [
            {"gap": gap, "force": force, "repeat": repeat, "state": "done", "word": "t1", "time": gap / force + repeat}
            for gap in (1e-3, 1e-2, 1e-1)
            for force in (1.0, 2.0)
            for repeat in (0, 2)
        ]
        return [*rows, {"gap": 1.0, "force": 1.0, "repeat": 0, "state": "failed", "word": "", "time": np.nan}]


def test_curves_are_means_with_their_errors():
    (axes, *_) = sweep_figure(Made(), "curves").axes
    first = axes.containers[0]
    np.testing.assert_allclose(first.lines[0].get_xydata(), [(1e-3, 1.001), (1e-2, 1.01), (1e-1, 1.1)])
    (bars,) = first.lines[2]
    np.testing.assert_allclose([np.ptp(one[:, 1]) for one in bars.get_segments()], 2.0)
    assert axes.get_xscale() == "log"
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["force = 1", "force = 2"]


def test_a_map_has_a_field_for_each_pair():
    (axes, *_) = sweep_figure(Made(), "map").axes
    (mesh,) = axes.collections
    np.testing.assert_allclose(mesh.get_array(), [[1.001, 1.01, 1.1], [1.0005, 1.005, 1.05]])


def test_fields_lie_around_their_values_on_a_logarithmic_axis():
    np.testing.assert_allclose(edges(np.array([1e-3, 1e-2, 1e-1])), 10.0 ** np.array([-3.5, -2.5, -1.5, -0.5]))


def test_a_scatter_has_a_dot_for_each_run():
    (axes, *_) = sweep_figure(Made(), "scatter").axes
    assert len(axes.collections[0].get_offsets()) == 12


@pytest.mark.parametrize(
    ("kind", "measure", "says"), [("pie", None, "no such figure"), ("curves", "word", "no measure")]
)
def test_what_there_is_not_is_refused(kind, measure, says):
    with pytest.raises(BadInput, match=says):
        sweep_figure(Made(), kind, measure)
