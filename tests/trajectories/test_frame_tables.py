"""Trajectories as tables, and as short texts."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ecume.errors import BadInput
from ecume.trajectories import tables
from ecume.trajectories.frame import Frame
from ecume.trajectories.reader import open_trajectory

Recorded = Callable[..., Path]


class Columns:
    """In place of a library: it keeps the columns that it is given."""

    @staticmethod
    def DataFrame(columns: Any) -> Any:  # noqa: N802  # the name that the libraries have
        return columns


def frames() -> list[Frame]:
    return [
        Frame(
            time=0.25 * number,
            arrays={
                "position": np.arange(6.0).reshape(3, 2) + 10.0 * number,
                "species": np.array([0, 1, 1]),
                "moment": np.full((3, 4), float(number)),
            },
            numbers={"energy": 2.0 + number, "clusters": 3.0},
            units={"position": "m", "energy": "J"},
        )
        for number in range(2)
    ]


def test_particles_have_a_row_per_frame_and_a_column_per_component() -> None:
    columns = tables.of_particles(frames())
    assert list(columns) == [
        "frame", "time", "particle", "position_x", "position_y", "species",
        "moment_0", "moment_1", "moment_2", "moment_3",
    ]  # fmt: skip
    assert columns["frame"].tolist() == [0, 0, 0, 1, 1, 1]
    assert columns["time"].tolist() == [0.0, 0.0, 0.0, 0.25, 0.25, 0.25]
    assert columns["particle"].tolist() == [0, 1, 2, 0, 1, 2]
    assert columns["position_y"].tolist() == [1.0, 3.0, 5.0, 11.0, 13.0, 15.0]
    assert columns["species"].dtype.kind == "i"


def test_no_frames_give_an_empty_table() -> None:
    assert {name: len(column) for name, column in tables.of_particles([]).items()} == {
        "frame": 0,
        "time": 0,
        "particle": 0,
    }


def test_a_trajectory_gives_its_numbers_or_its_particles(recorded: Recorded, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "polars", Columns)
    monkeypatch.setitem(sys.modules, "pandas", Columns)
    with open_trajectory(recorded(5).parent) as trajectory:
        for numbers in (trajectory.polars(), trajectory.pandas()):
            assert list(numbers) == ["frame", "time", "kinetic_energy", "contacts"]
            assert numbers["kinetic_energy"].tolist() == [frame.numbers["kinetic_energy"] for frame in trajectory]
        particles = trajectory.polars(particles=True)
        assert len(particles["particle"]) == 5 * 6
        assert particles["velocity_y"][-1] == trajectory[-1].arrays["velocity"][-1, 1]
        monkeypatch.setitem(sys.modules, "pandas", None)
        with pytest.raises(BadInput, match=r"pandas is not installed: pip install 'pandas.* 'polars"):
            trajectory.pandas()


@pytest.mark.parametrize("library", ["polars", "pandas"])
def test_libraries_take_the_tables_of_a_trajectory(recorded: Recorded, library: str) -> None:
    with open_trajectory(recorded(5).parent) as trajectory:
        table = getattr(trajectory, library)(particles=True)
        assert len(table) == 30
        assert list(table.columns)[:4] == ["frame", "time", "particle", "position_x"]


def test_a_frame_and_a_trajectory_print_in_a_line(recorded: Recorded) -> None:
    text = repr(frames()[1])
    assert text == "Frame(time=0.25 s, 3 particles; arrays: position, species, moment; numbers: energy, clusters)"
    many = frames()[1]._replace(numbers={f"number_{k}": 1.0 for k in range(9)})
    assert repr(many).endswith("numbers: number_0, number_1, number_2, number_3, number_4, 4 more)")
    folder = recorded(5)
    with open_trajectory(folder.parent) as trajectory:
        assert repr(trajectory) == f"Trajectory({str(folder.parent)!r}, 5 frames, 0 s to 0.4 s)"
