"""How the surface flows where a float is."""

from __future__ import annotations

from ecume._jit import compiled, compiled_inside
from ecume.models.floating.parameters import Drift
from ecume.units import Array


@compiled_inside
def straight_current(flow: Array, x: float, y: float) -> tuple[float, float]:
    """That of a flow which is uniform, and linear in the place."""
    return flow[0] + flow[2] * x + flow[3] * y, flow[1] + flow[4] * x + flow[5] * y


@compiled
def current_at(drift: Drift, x: float, y: float) -> tuple[float, float]:
    """The velocity of the surface (m/s)."""
    along, across = straight_current(drift.flow, x, y)
    if drift.nodes.shape[1] > 0:
        more_along, more_across = between_nodes(drift, x, y)
        along, across = along + more_along, across + more_across
    return along, across


@compiled
def between_nodes(drift: Drift, x: float, y: float) -> tuple[float, float]:
    """That of a table: straight along x and along y between its nodes, beyond it as at its edge."""
    nodes, frame = drift.nodes, drift.frame
    last_x, last_y = nodes.shape[1] - 1.0, nodes.shape[2] - 1.0
    u = min(max((x - frame[0]) * frame[2], 0.0), last_x)
    v = min(max((y - frame[1]) * frame[3], 0.0), last_y)
    i, j = int(min(u, last_x - 1.0)), int(min(v, last_y - 1.0))
    u, v = u - i, v - j
    low, high = (1.0 - u) * (1.0 - v), u * (1.0 - v)
    left, right = (1.0 - u) * v, u * v
    along = low * nodes[0, i, j] + high * nodes[0, i + 1, j] + left * nodes[0, i, j + 1]
    across = low * nodes[1, i, j] + high * nodes[1, i + 1, j] + left * nodes[1, i, j + 1]
    return along + right * nodes[0, i + 1, j + 1], across + right * nodes[1, i + 1, j + 1]
