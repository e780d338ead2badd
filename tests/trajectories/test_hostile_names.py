"""Names in files of frames, which may come from anyone: no path, no formula and no line break gets into an export."""

from __future__ import annotations

import ast
import csv
import io
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from some_frames import frame_at

import ecume
from ecume.errors import BadInput, StorageError
from ecume.trajectories import gsd
from ecume.trajectories.exports import EXPORTS, export
from ecume.trajectories.frame import Frame
from ecume.trajectories.reader import open_trajectory
from ecume.trajectories.segments import Recorder
from ecume.trajectories.tables import FORMULA, cell, write_rows

HOSTILE = [
    "../../../evil",
    "/evil",
    "a\nb",
    "=cmd|' /C calc'!A0",
    "",
    ".",
    "a/b",
    "a b",
    "\u202ea",
    "x" * 300,
    "a\x1b",
    '"',
    "-",
    "a,b",
]
PLACES = ("array", "number", "unit", "species")
PRINTABLE = [name for name in HOSTILE if len(name) < 200 and (name.isprintable() or name[0] == "\u202e")]


def named(where: str, name: str) -> Frame:
    """A frame with this name somewhere."""
    frame = frame_at(0)
    if where == "array":
        return frame._replace(arrays={**frame.arrays, name: np.arange(6.0)})
    if where == "number":
        return frame._replace(numbers={**frame.numbers, name: 1.0})
    return frame._replace(units=dict.fromkeys(frame.units, name)) if where == "unit" else frame


@pytest.fixture
def forged(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[str, str], Path]:
    """Makes a trajectory with a name that no run writes."""

    def record(where: str, name: str) -> Path:
        with monkeypatch.context() as changed:
            changed.setattr(gsd, "NAME", re.compile(r"(?s).*"))
            changed.setattr(gsd, "LABEL", re.compile(r"(?s).*"))
            with Recorder(tmp_path / "run" / "traj", species=[name] if where == "species" else ["a"]) as recorder:
                recorder.write(named(where, name), 0)
        return tmp_path / "run"

    return record


@pytest.mark.parametrize("where", PLACES)
@pytest.mark.parametrize("name", HOSTILE)
def test_no_name_of_a_file_acts_in_an_export(
    forged: Callable[[str, str], Path], tmp_path: Path, where: str, name: str
) -> None:
    """Names of arrays and numbers are those of scenes; units and species are text without control characters."""
    made = forged(where, name)
    if where in ("array", "number") or name not in PRINTABLE:
        with pytest.raises(StorageError, match="not written by ecume"):
            open_trajectory(made)
        return
    open_trajectory(made).close()
    for kind in sorted({*EXPORTS, "pvd"} - {"samples"}):
        export(made, kind, tmp_path / f"out.{kind}")
    for kind in ("csv", "numbers"):
        heads = next(csv.reader((tmp_path / f"out.{kind}").read_text().splitlines()))
        assert not any(one.startswith(FORMULA) for one in heads)
    count, _, *rest = (tmp_path / "out.xyz").read_text().splitlines()
    assert len(rest) == int(count)


@pytest.mark.parametrize("where", ["array", "number"])
@pytest.mark.parametrize("name", HOSTILE)
def test_no_run_writes_such_a_name(tmp_path: Path, where: str, name: str) -> None:
    with Recorder(tmp_path) as recorder, pytest.raises(BadInput, match="expected at most 200 letters"):
        recorder.write(named(where, name), 0)


def test_text_that_a_spreadsheet_would_evaluate_begins_with_an_apostrophe() -> None:
    text = io.StringIO()
    write_rows(text, [["=1+1", "+a", "-a", "@b", "\tc", "-1.5e-3 mm", "-inf", "a=b"], [-1.0, -2, None, True]])
    first, second = csv.reader(io.StringIO(text.getvalue()))
    assert first == ["'=1+1", "'+a", "'-a", "'@b", "'\tc", "-1.5e-3 mm", "-inf", "a=b"]
    assert second == ["-1.0", "-2", "", "True"]
    assert cell("-1+cmd|' /C calc'!A0") == "'-1+cmd|' /C calc'!A0"


@pytest.mark.long
def test_all_tables_are_written_with_this_protection() -> None:
    """Names in tables of sweeps and figures come from scenes, which may be anyone's."""
    calls = {
        path.name
        for path in Path(ecume.__file__).parent.rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Attribute) and node.attr in ("writer", "DictWriter", "to_csv", "write_csv", "savetxt")
    }
    assert calls == {"tables.py"}
