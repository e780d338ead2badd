"""Figures of clusters over time: raft sizes, topologies and the transitions between them."""

from __future__ import annotations

from collections import Counter
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from matplotlib.ticker import MaxNLocator

from ecume.analysis.clusters import (
    Clusters,
    Topology,
    arrangement,
    entropy_production,
    mean_raft,
    shares_by_size,
    topologies,
    touching_clusters,
    transitions,
)
from ecume.analysis.series import BLOCKS, times
from ecume.analysis.structure import whole
from ecume.errors import BadInput
from ecume.show.curves import Frames, evolution, span, titled
from ecume.show.style import INK, MUTED, PALETTE, figure, legend_outside, style
from ecume.trajectories.frame import Frame
from ecume.units import Array

BOND = 0.1
"""Gap, over the smaller radius, up to which floats count as touching: thermal and active floats touch for instants
only.
"""
LARGEST = 10
"""Floats of the largest cluster whose topology is drawn."""
MOST_BARS = 8
MOST_STATES = 8
MOST_FRAMES = 20_000


def raft_sizes(frames: Frames, scene: Any) -> Figure:
    """The shares of the floats in rafts of one, two to three, four to seven floats and so on, over time; and the mean
    number of floats in the raft of a float.
    """
    shown = evolution(frames)
    found = [touching_clusters(frame, tolerance=BOND) for frame in shown]
    largest = max(each.largest for each in found)
    edges = [2**n for n in range(max(largest.bit_length(), 1))]
    shares = np.array([shares_by_size(each, edges) for each in found]).T
    with style():
        drawn = figure(6.4, 4.8)
        above, below = drawn.subplots(2, 1, sharex=True)
        colors = colormaps["viridis"](np.linspace(0.95, 0.1, len(edges)))
        labels = [str(low) if low == 1 else f"{low} – {2 * low - 1}" for low in edges]
        above.stackplot(times(shown), shares, colors=colors, labels=labels)
        above.set(ylim=(0.0, 1.0), ylabel="share of the floats", title=titled("Raft sizes", scene))
        legend_outside(above, "floats in a raft")
        below.plot(times(shown), [mean_raft(each) for each in found], color=PALETTE[1])
        below.set(xlabel="time (s)", ylabel="floats in a raft", xlim=span(times(shown)))
        below.set_ylim(bottom=0.0)
        below.yaxis.set_major_locator(MaxNLocator(nbins=6))
    return drawn


def topology_figure(frames: Frames, scene: Any) -> Figure:
    """The most frequent topologies of clusters over all frames, at most ten floats each: how often each appears, with
    its contacts and symmetry number.
    """
    counts: Counter[Topology] = Counter()
    examples: dict[Topology, Array] = {}
    for frame in _read(frames):
        clusters = touching_clusters(frame, tolerance=BOND)
        if not np.any((clusters.sizes > 1) & (clusters.sizes <= LARGEST)):
            continue
        for label, each in _small(frame, clusters):
            counts[each] += 1
            if each not in examples:
                examples[each] = _drawing(frame, clusters, label)
    if not counts:
        raise BadInput(f"no clusters of 2 to {LARGEST} floats in any frame; no topology to draw")
    total, chosen = sum(counts.values()), counts.most_common(MOST_BARS)
    with style():
        drawn = figure(1.5 + 0.85 * max(len(chosen), 4), 4.4)
        axes, below = drawn.subplots(2, 1, height_ratios=(3.0, 1.4), sharex=True)
        axes.bar(range(len(chosen)), [count / total for _, count in chosen], color=PALETTE[1], width=0.6)
        axes.set(ylabel="share of the clusters", title=titled("Topologies", scene))
        axes.tick_params(axis="x", labelbottom=False, length=0)
        axes.set_xlim(-0.6, len(chosen) - 0.4)
        for place, (topology, _) in enumerate(chosen):
            _draw(below, place, examples[topology])
        names = [f"{each.contacts} contacts\nσ = {each.symmetry}" for each, _ in chosen]
        below.set_xticks(range(len(chosen)), names, fontsize=8)
        below.set(ylim=(-0.55, 0.55), yticks=[], aspect="equal", anchor="N")
        below.grid(visible=False)
        below.spines[:].set_visible(False)
    return drawn


def transition_figure(frames: Frames, scene: Any) -> Figure:
    """The transitions between arrangements of all floats from frame to frame, at most ten floats: the share of the
    changes from each of the most frequent states that lead to each other one, and the entropy production rate.
    """
    count = len(frames[0].arrays["radius"])
    if count > LARGEST:
        raise BadInput(f"the run has {count} floats; expected at most {LARGEST} for transitions of their arrangement")
    shown = _read(frames)
    if len(shown) < 2:
        raise BadInput(f"the run has a single frame, at {frames[0].time:g} s; transitions need two frames or more")
    sequence = [arrangement(frame, tolerance=BOND) for frame in shown]
    found = transitions(sequence)
    kept = min(len(found.states), MOST_STATES)
    changes = found.counts[:kept, :kept] * (1.0 - np.eye(kept))
    rows = changes.sum(axis=1, keepdims=True)
    shares = np.divide(changes, rows, out=np.zeros_like(changes), where=rows > 0)
    note = ""
    if len(sequence) >= 4 * BLOCKS:
        every = (shown[-1].time - shown[0].time) / (len(shown) - 1)
        rate = entropy_production([sequence], every)
        note = f"entropy production ({rate.value:.2g} ± {rate.error:.1g}) k$_B$/s"
    with style():
        drawn = figure(6.4, 5.2)
        axes = drawn.add_subplot(xlabel="to", ylabel="from", title=titled("Transitions of arrangements", scene))
        image = axes.imshow(shares, cmap="Blues", vmin=0.0, vmax=max(float(shares.max()), 1e-12))
        for i in range(kept):
            for j in range(kept):
                color = "white" if shares[i, j] > 0.6 * shares.max() else INK
                axes.text(j, i, f"{found.counts[i, j]}", ha="center", va="center", fontsize=7, color=color)
        names = [_short(state) for state in found.states[:kept]]
        axes.set_xticks(range(kept), names, rotation=45, ha="right", fontsize=7)
        axes.set_yticks(range(kept), names, fontsize=7)
        axes.grid(visible=False)
        drawn.colorbar(image, ax=axes, label="share of the changes")
        if note:
            drawn.text(0.99, 0.005, note, ha="right", va="bottom", fontsize=8, color=MUTED)
    return drawn


def _read(frames: Frames) -> list[Frame]:
    """All frames, or `MOST_FRAMES` consecutive ones at the end."""
    start = max(len(frames) - MOST_FRAMES, 0)
    return [frames[index] for index in range(start, len(frames))]


def _small(frame: Frame, clusters: Clusters) -> list[tuple[int, Topology]]:
    """The clusters of 2 to `LARGEST` floats with their topologies."""
    if clusters.largest > LARGEST:
        kept = clusters.sizes[clusters.labels] <= LARGEST
        numbers = np.unique(clusters.labels[kept])
        part = frame._replace(arrays={name: frame.arrays[name][kept] for name in ("position", "radius")})
    else:
        numbers, part = np.arange(len(clusters.sizes)), frame
    every = zip(numbers.tolist(), topologies(part, tolerance=BOND), strict=True)
    return [(label, each) for label, each in every if each.floats > 1]


def _drawing(frame: Frame, clusters: Clusters, label: int) -> Array:
    """Centers and radii of a cluster, (floats, 3), scaled to a circle of radius 0.5."""
    members = clusters.labels == label
    center, radius = whole(frame, clusters)[members], frame.arrays["radius"][members]
    center = center - center.mean(axis=0)
    reach = float(np.max(np.linalg.norm(center, axis=1) + radius))
    return np.column_stack([center, radius]) * 0.5 / reach


def _draw(axes: Axes, place: int, cluster: Array) -> None:
    for x, y, radius in cluster:
        axes.add_patch(
            Circle((place + 0.9 * x, 0.9 * y), 0.9 * radius, facecolor=PALETTE[1], edgecolor=INK, linewidth=0.5)
        )


def _short(state: str) -> str:
    """A state without its single floats; they follow from the number of floats.

    >>> _short("1-0-0+1-0-0+3-3-7")
    '3-3-7'
    """
    several = [label for label in state.split("+") if not label.startswith("1-")]
    return "+".join(several) or "apart"


CLUSTER_FIGURES = {"raft-sizes": raft_sizes, "topologies": topology_figure, "transitions": transition_figure}
"""By the names that `ecume plot --what` takes."""
