"""Figures of a liquid show what the frames hold, with units."""

import math
import re

import numpy as np
import pytest

from ecume.errors import BadInput
from ecume.show.sph import figures
from ecume.show.sph.figures import SPH_FIGURES

from .conftest import frame_of, scene_of

WITH_UNIT = re.compile(r".* \((s|[kmµ]?(m|m/s|J|Pa))\)$")


@pytest.mark.parametrize("what", [name for name in SPH_FIGURES if name not in ("gauges", "forces")])
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


@pytest.mark.parametrize(("method", "remarks"), [("incompressible", [1, 0]), ("tait", [0, 0])])
def test_single_readings_of_an_incompressible_liquid_are_called_so(frames, method, remarks):
    """Where it may hit a wall: their size depends on the time step."""
    read = [
        frame._replace(
            numbers={**frame.numbers, "P_pressure": frame.time, "P_level": 1.0},
            units=frame.units | {"P_pressure": "Pa", "P_level": "m"},
        )
        for frame in frames
    ]
    probe = {"name": "P", "position": [1.0, 0.2], "quantities": ["pressure", "level"]}
    drawn = figures.gauges(read, scene_of(gauges=[probe], method={"pressure": method}))
    found = [sum("averages" in text.get_text() for text in axes.texts) for axes in drawn.axes]
    assert found == remarks


def felt(frame, **forces):
    """The frame with forces on solids (N/m)."""
    units = dict.fromkeys(forces, "N/m")
    return frame._replace(numbers={**frame.numbers, **forces}, units={**frame.units, **units})


def test_forces_on_solids_are_drawn_or_else_those_on_sides(scene, frames):
    with pytest.raises(BadInput, match="no force to draw"):
        figures.forces(frames, scene)
    sides = [felt(one, bottom_force_x=0.0, bottom_force_y=-9810.0 - one.time) for one in frames]
    (axes,) = figures.forces(sides, scene).axes
    assert axes.get_ylabel() == "force (kN/m)"
    assert axes.lines[1].get_ydata() == pytest.approx([-9.81, -9.8101, -9.8102], rel=1e-12)
    solids = [felt(one, obstacle0_force_x=3.0, obstacle0_force_y=4.0) for one in sides]
    (axes,) = figures.forces(solids, scene).axes
    assert [line.get_label() for line in axes.lines] == ["obstacle0, x", "obstacle0, y"]


def test_of_many_solids_the_figure_draws_the_largest_forces_and_says_so(scene, frames):
    forces = {f"post{n}_force_{axis}": float(n) for n in range(9) for axis in "xy"}
    drawn = figures.forces([felt(one, **forces) for one in frames], scene)
    labels = [axes.lines[0].get_label() for axes in drawn.axes]
    assert labels == [f"post{n}, x" for n in range(3, 9)]
    assert "on 6 of 9 solids" in drawn.axes[0].get_title(loc="left")


def test_a_scene_without_gauges_has_no_figure_of_them(scene, frames):
    with pytest.raises(BadInput, match="no gauges"):
        figures.gauges(frames, scene)


def beside(height, solids, **more):
    """A still column of liquid of this height beside solids, and the scene."""
    scene = scene_of(fluid=[{"low": [0.0, 0.0], "high": [2.0, height]}], **solids, **more)
    axes = [0.05 * (np.arange(40) + 0.5), 0.05 * (np.arange(round(height / 0.05)) + 0.5)]
    position = np.stack([grid.ravel() for grid in np.meshgrid(*axes, indexing="ij")], axis=1)
    full, x, y = frame_of(), *position.T
    disc = np.hypot(x - 1.0, y - 0.3) < 0.2 if "obstacles" in solids else (np.abs(x - 1.0) < 0.2) & (y > 0.3)
    count = int((~disc).sum())
    arrays = {
        "position": position[~disc],
        "velocity": np.zeros((count, 2)),
        "pressure": 9810.0 * (height - y[~disc]),
        "density": np.full(count, 1000.0),
        "mass": np.full(count, 2.5),
        "species": np.zeros(count, np.int64),
    }
    numbers = {**full.numbers, "body0_x": 1.0, "body0_y": 0.5, "body0_angle": 0.0}
    return scene, [full._replace(arrays=arrays, numbers=numbers)]


DISC = {"obstacles": [{"center": [1.0, 0.3], "radius": 0.2}]}
FLOAT = {"bodies": [{"low": [0.8, 0.3], "high": [1.2, 0.7], "density": 500.0}]}


@pytest.mark.long
@pytest.mark.parametrize("solids", [DISC, FLOAT])
def test_the_exact_column_stands_as_high_as_the_liquid_beside_solids(solids):
    """Half of the float is under water, and the disc all of it."""
    scene, still = beside(0.5, solids, gravity=[0.0, -9.81])
    solid = math.pi * 0.2**2 if "obstacles" in solids else 0.4 * 0.2
    level = (still[0].arrays["mass"].sum() / 1000.0 + solid) / 2.0
    (axes,) = figures.pressure(still, scene).axes
    _, column = (line.get_data() for line in axes.lines)
    assert axes.get_ylabel() == "height (mm)"
    assert column[1].max() == pytest.approx(1000.0 * level, rel=3e-3)


@pytest.mark.parametrize("solids", [DISC, FLOAT])
def test_the_surface_does_not_run_around_solids(solids):
    scene, still = beside(0.5, solids)
    (axes,) = figures.surface(still, scene).axes
    across, heights = np.concatenate([line.get_data() for line in axes.lines[:-1]], axis=1)
    assert heights == pytest.approx(0.5, abs=0.03)
    assert (np.abs(across - 1.0) < 0.15).any() == ("obstacles" in solids)


def test_figures_of_a_tank_that_all_liquid_has_left_are_drawn_or_refused_in_a_sentence(scene, frames):
    last = frames[-1]
    empty = last._replace(time=2.0 * last.time, arrays={name: array[:0] for name, array in last.arrays.items()})
    for what in ("snapshot", "velocity", "energies", "surface"):
        SPH_FIGURES[what]([*frames, empty], scene)
    for what in ("pressure", "dynamic-pressure"):
        with pytest.raises(BadInput, match="all liquid has left the tank"):
            SPH_FIGURES[what]([*frames, empty], scene)
