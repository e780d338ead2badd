"""A surface's flow from a table: velocities at the nodes of a grid."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path as Folder
from typing import Any

from ecume.scenes.faults import Complaints
from ecume.scenes.files import beside, require_there, text_of
from ecume.scenes.tables import MOST_BYTES, followed, lines_of

TABLE = "velocity_from"
COLUMNS = {"x": "m", "y": "m", "vx": "m/s", "vy": "m/s"}
EVEN = 1e-6
"""How far nodes may be from equal steps, over a step."""


def follow_current(raw: dict[str, Any], folder: Folder) -> Complaints:
    """Put what the flow's table says into `raw`; what is wrong with it comes back."""
    liquid = raw.get("liquid")
    flow = liquid.get("flow") if isinstance(liquid, dict) else None
    if not isinstance(flow, dict) or TABLE not in flow:
        return []
    return followed(("liquid", "flow", TABLE), _nodes_from, flow, flow.pop(TABLE), folder)


def _nodes_from(flow: dict[str, Any], name: str, folder: Folder) -> None:
    path = beside(folder, name)
    require_there(path, folder)
    lines = lines_of(text_of(path, MOST_BYTES), COLUMNS)
    if missing := [column for column in COLUMNS if column not in lines[0].values]:
        raise ValueError(f"has no column {missing[0]}; wanted x, y, vx and vy")
    flow["nodes"] = nodes_of([[line.values[column] for column in COLUMNS] for line in lines])


def nodes_of(rows: Sequence[Sequence[float]]) -> dict[str, Any]:
    """A `NodesSpec` from rows of x, y, vx and vy in any order. Raises ValueError where they are no grid.

    >>> nodes_of([(0, 0, 1, 2), (1, 0, 3, 4), (0, 1, 5, 6), (1, 1, 7, 8)])["vx"]
    [[1, 5], [3, 7]]
    """
    x, y = (sorted({row[axis] for row in rows}) for axis in (0, 1))
    at = {(row[0], row[1]): (row[2], row[3]) for row in rows}
    if len(at) != len(rows):
        raise ValueError("has a node twice")
    if len(x) < 2 or len(y) < 2 or len(at) != len(x) * len(y):
        raise ValueError(f"is no grid: {len(at)} nodes, with {len(x)} different x and {len(y)} different y")
    for axis, places in (("x", x), ("y", y)):
        _require_even(axis, places)
    along, across = ([[at[i, j][part] for j in y] for i in x] for part in (0, 1))
    return {"low": [x[0], y[0]], "high": [x[-1], y[-1]], "vx": along, "vy": across}


def _require_even(axis: str, places: Sequence[float]) -> None:
    step = (places[-1] - places[0]) / (len(places) - 1)
    if any(abs(place - places[0] - k * step) > EVEN * step for k, place in enumerate(places)):
        raise ValueError(f"is uneven along {axis}; wanted equal steps of {step:g} m")
