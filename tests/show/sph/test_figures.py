"""Figures of a liquid show what the frames hold, with units."""

import re

import numpy as np
import pytest

from ecume.errors import BadInput
from ecume.show.sph import figures
from ecume.show.sph.figures import SPH_FIGURES

from .conftest import frame_of, scene_of

WITH_UNIT = re.compile(r".* \((s|[kmµ]?(m|m/s|J|Pa))\)$")


@pytest.mark.parametrize("what", [name for name in SPH_FIGURES if name != "gauges"])
def test_every_figure_can_be_drawn_with_units_and_refuses_one_frame_where_it_needs_two(what, scene, frames):
    if what in ("energies", "kinetic-energy", "front", "center"):
        with pytest.raises(BadInput, match="the run has a single frame"):
            SPH_FIGURES[what](frames[:1], scene)
    for shown in (frames, frames[:1] * 2):
        drawn = SPH_FIGURES[what](shown, scene)
        labels = [label for axes in drawn.axes for label in (axes.get_xlabel(), axes.get_ylabel()) if label]
        assert labels
        assert all(WITH_UNIT.match(label) for label in labels)


def test_a_liquid_at_rest_lies_on_the_exact_column(scene, frames):
    (axes,) = figures.pressure(frames, scene).axes
    dots, column = (line.get_data() for line in axes.lines)
    on_column = np.interp(dots[1], column[1][::-1], column[0][::-1])
    assert dots[0] == pytest.approx(on_column, abs=0.01 * column[0].max())


def test_without_a_depth_there_is_no_pressure_against_it(frames):
    sideways = scene_of(gravity=[9.81, 0.0])
    with pytest.raises(BadInput, match="the hydrostatic pressure is not defined"):
        figures.pressure(frames, sideways)


def test_velocities_are_read_along_the_middle(scene, frames):
    up, across = figures.velocity(frames[:1], scene).axes
    speed, height = up.lines[0].get_data()
    wet = np.isfinite(speed) & (height > 0.05) & (height < 0.45)
    assert speed[wet] == pytest.approx(3.0 * height[wet], abs=0.02)
    assert across.lines[0].get_ydata()[10:50] == pytest.approx(0.0, abs=1e-9)


def test_a_surface_in_space_is_refused(frames):
    with pytest.raises(BadInput, match="in 2D"):
        figures.surface([frame_of(dimension=3)], scene_of(dimension=3))


def test_a_liquid_that_fills_its_tank_has_no_free_surface_and_one_that_flows_through_no_front(frames):
    full = frame_of()
    closed = scene_of(tank={"low": [0.0, 0.0], "high": [2.0, 0.5]})
    with pytest.raises(BadInput, match="no free surface"):
        figures.surface([full], closed)
    through = {"left": {"kind": "inflow", "speed": 1.0}, "right": {"kind": "outflow"}}
    flowing = scene_of(tank={"low": [0.0, 0.0], "high": [2.0, 0.5], **through})
    with pytest.raises(BadInput, match="flows through"):
        figures.front(frames, flowing)


def test_gauges_are_drawn_by_kind_over_time(frames):
    probes = [
        {"name": "P", "position": [1.0, 0.2]},
        {"name": "V", "position": [0.5, 0.1], "end": [0.5, 0.3], "count": 2},
    ]
    probes[1]["quantities"] = ["velocity", "level"]
    extra = {"P_pressure": "Pa"}
    extra |= {f"V_{n}_{what}": unit for n in (1, 2) for what, unit in (("level", "m"), ("velocity_x", "m/s"))}
    read = [
        frame._replace(numbers={**frame.numbers, **dict.fromkeys(extra, frame.time + 1.0)}, units=frame.units | extra)
        for frame in frames
    ]
    drawn = figures.gauges(read, scene_of(gauges=probes))
    pressure, _, velocity = drawn.axes
    assert [len(axes.lines) for axes in drawn.axes] == [1, 2, 2]
    assert pressure.lines[0].get_ydata() == pytest.approx([1.0, 1.1, 1.2])
    assert [axes.get_ylabel() for axes in drawn.axes] == ["pressure (Pa)", "level (m)", "velocity (m/s)"]
    assert [text.get_text() for text in velocity.get_legend().get_texts()] == ["V_1_x", "V_2_x"]


def test_a_scene_without_gauges_has_no_figure_of_them(scene, frames):
    with pytest.raises(BadInput, match="no gauges"):
        figures.gauges(frames, scene)
