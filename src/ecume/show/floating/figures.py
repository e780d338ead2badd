"""The figures of the floating model: trajectories, structure, rafts and forces.

Figures of rafts in time and space come first, the table last.
"""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.collections import EllipseCollection, LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from matplotlib.ticker import LogLocator, MaxNLocator, NullFormatter
from scipy.integrate import solve_ivp
from scipy.spatial import cKDTree

from ecume.analysis.boxes import box_of
from ecume.analysis.clusters import (
    Clusters,
    Topology,
    arrangement,
    entropy_production,
    mean_raft,
    shares_by_size,
    topologies,
    touching_clusters,
    touching_pairs,
    transitions,
)
from ecume.analysis.series import times, tracks
from ecume.analysis.structure import (
    Region,
    approach,
    fractal_dimension,
    hexatic_order,
    pair_distribution,
    region_in,
    shapes_of,
    whole,
)
from ecume.engine.stationarity import BLOCKS
from ecume.engine.walls.rings import shrunk
from ecume.errors import BadInput
from ecume.laws.drag import schiller_naumann_factor
from ecume.laws.pair_laws import PAIR_LAWS, PairLaw, PairParameters, Setting
from ecume.models.floating.dishes import walls_of
from ecume.models.floating.forces.pair_forces import constants_of, law_of, two_floats
from ecume.models.floating.setup.scene_parameters import checked_parameters
from ecume.models.liquids import liquid_of
from ecume.show.curves import (
    Frames,
    clusters,
    displacement,
    energies,
    evolution,
    instants,
    kinetic_energy,
    over_time,
    scaling,
    span,
    thinned,
    titled,
)
from ecume.show.floating.bowl import Bowl, dish_outline, inner_walls, view_of
from ecume.show.picture import species, species_dots
from ecume.show.style import INK, MUTED, PALETTE, binned, figure, legend_outside, plain, scale_for, style
from ecume.trajectories.frame import Frame
from ecume.units import Array

MOST_PAIRS = 12
BINS = 120
MOST_FOR_NO_FIT = 3
"""The largest raft size without a fit of the fractal dimension."""
CONTACT = 1e-4
"""How far below the distance of contact a bin begins, over that distance."""
SHELLS = 12.0
"""The least range of the pair distribution, in mean radii."""
SPACINGS = 3.0
"""The least range of it in distances to the nearest neighbor, of floats that are far apart."""


def order(frames: Frames, scene: Any) -> Figure:
    """The hexatic order over time: the local order, and the global order."""
    shown = evolution(frames)
    psi = [hexatic_order(frame) for frame in shown]
    with style():
        drawn = figure()
        axes = over_time(drawn, scene, "Hexatic order")
        axes.plot(
            times(shown),
            [np.abs(each).mean() for each in psi],
            color=PALETTE[1],
            label="local, $\\langle|\\psi_6|\\rangle$",
        )
        axes.plot(
            times(shown),
            [abs(each.mean()) for each in psi],
            color=PALETTE[0],
            label="global, $|\\langle\\psi_6\\rangle|$",
        )
        axes.set(ylim=(0.0, 1.0), ylabel=r"hexatic order $|\psi_6|$")
        legend_outside(axes)
    return drawn


def _nearest(position: Array) -> float:
    """The median distance of a particle to its nearest neighbor; zero for a single particle."""
    if len(position) < 2:
        return 0.0
    distance, _ = cKDTree(position).query(position, k=2)
    return float(np.median(np.asarray(distance)[:, 1]))


def distribution(frames: Frames, scene: Any) -> Figure:
    """The pair distribution: the mean over all frames, and that of the first frame. A bin begins at contact."""
    shown = thinned(frames)
    region = region_of(shown[-1], scene)
    radius = float(shown[-1].arrays["radius"].mean())
    # Floats at rest in contact overlap by up to 1e-4 of a radius.
    contact = 2.0 * radius * (1.0 - CONTACT)
    reach = max(SHELLS * radius, SPACINGS * _nearest(shown[-1].arrays["position"]))
    width = reach / BINS
    below = np.arange(contact, 0.0, -width)[::-1]
    edges = np.concatenate([[0.0], below[below > 0.0], np.arange(contact + width, reach, width)])
    edges = edges[edges < region.widest]
    with style():
        drawn = figure()
        axes = drawn.add_subplot(
            xlabel="distance of the centers, in mean radii", title=titled("Pair distribution", scene)
        )
        rows = [(shown[:1], MUTED, f"first, {shown[0].time:.3g} s"), (shown, PALETTE[1], f"all {len(shown)} frames")]
        for some, color, label in rows:
            binned(axes, pair_distribution(some, edges, region), edges / radius, color=color, label=label)
        axes.axhline(1.0, color=INK, linewidth=0.6)
        axes.set(xlim=(0.0, edges[-1] / radius), ylabel="pair distribution g(r)")
        axes.set_ylim(bottom=0.0)
        axes.legend()
    return drawn


def region_of(frame: Frame, scene: Any) -> Region:
    """The region of the centers: the dish reduced by a radius; without a dish, the rectangle around all floats."""
    radius = float(frame.arrays["radius"].min())
    if scene.cell is not None:
        return Region(size=scene.sides, periodic=True)
    if scene.dish is not None:
        return region_in(shrunk(walls_of(scene.dish), radius))
    across, along = np.ptp(frame.arrays["position"], axis=0) + 2.0 * radius
    return Region(size=(float(across), float(along)))


def approaches(frames: Frames, scene: Any) -> Figure:
    """The gaps of pairs that touch at the end, over time, up to their contact."""
    shown, kept = evolution(frames), instants(frames)
    last = shown[-1].arrays
    box = box_of(shown[-1])
    period = None if box is None else box.sides.tolist()
    pairs = touching_pairs(last["position"], last["radius"], period=period)[:MOST_PAIRS]
    if not len(pairs):
        raise BadInput("no floats are in contact in the last frame; no approach to draw")
    length, paths = liquid_of(scene).capillary_length, tracks(frames, kept)
    with style():
        drawn = figure()
        axes = over_time(drawn, scene, "Gaps of floats that touch in the end")
        gaps = []
        for (i, j), color in zip(pairs, itertools.cycle(PALETTE), strict=False):
            gap = approach(paths, last["radius"], (int(i), int(j)), box) / length
            gaps.append(np.where(gap > 1e-4, gap, np.nan))
            axes.plot(times(shown), gaps[-1], color=color, linewidth=1.0, label=f"floats {i} and {j}")
        axes.set(yscale=scaling(gaps), ylabel="gap, in capillary lengths")
        legend_outside(axes)
    return drawn


def distances(frames: Frames, scene: Any) -> Figure:
    """The gap (mm) of the only two floats, or of pairs that are in contact at the end, over time; for two floats also
    the solution of their equation of motion.
    """
    shown = evolution(frames)
    radius, box = shown[-1].arrays["radius"], box_of(shown[-1])
    period = None if box is None else box.sides.tolist()
    pairs = touching_pairs(shown[-1].arrays["position"], radius, period=period)[:MOST_PAIRS].tolist()
    if len(radius) == 2:
        pairs = [[0, 1]]
    if not pairs:
        raise BadInput("no floats are in contact in the last frame; no approach to draw")
    paths, now = tracks(shown), times(shown)
    with style():
        drawn = figure()
        axes = over_time(
            drawn, scene, "Gap of two floats" if len(pairs) == 1 else "Gaps of floats that touch in the end"
        )
        marked = False
        for (i, j), color in zip(pairs, itertools.cycle(PALETTE), strict=False):
            gap = approach(paths, radius, (i, j), box)
            axes.plot(now, 1e3 * gap, color=color, label=f"floats {i} and {j}")
            met = np.flatnonzero(gap < MET * (radius[i] + radius[j]))
            if len(met):
                name = "_contact" if marked else "contact"
                axes.plot(now[met[:1]], 1e3 * gap[met[:1]], "o", color=color, markersize=5, label=name)
                marked = True
        if (solution := two_body_gap(shown, scene)) is not None:
            axes.plot(*(solution * [[1.0], [1e3]]), "--", color=INK, linewidth=1.0, label="equation of motion of two")
        axes.margins(y=0.05)
        axes.set_ylabel("gap (mm)")
        axes.set_ylim(bottom=0.0)
        legend_outside(axes)
    return drawn


MET = 0.03
"""The gap over the sum of radii below which a contact is marked; between two frames floats may touch and bounce."""


def two_body_gap(frames: Frames, scene: Any) -> Array | None:
    """Times (s) and gaps (m), shape (2, T), of two floats without other forces, m x'' = F(r) - friction x', up to
    contact; None for other scenes.
    """
    row, first = PAIR_LAWS[str(scene.interaction.law)], frames[0]
    if len(first.arrays["radius"]) != 2 or not _alone(scene) or not (row.has_force and row.reciprocal):
        return None
    parameters = checked_parameters(scene)
    floats, law, touching = parameters.floats, law_of(parameters), float(parameters.floats.radius.sum())
    own = two_floats(parameters, tuple(floats.radius.tolist()), tuple(floats.charge.tolist()))
    friction = floats.mass / floats.relaxation_time
    apart = first.arrays["position"][1] - first.arrays["position"][0]
    start = float(np.hypot(*apart))
    velocity = first.arrays.get("velocity", np.zeros((2, 2)))
    speeds, across = velocity @ (apart / start), velocity @ (apart[::-1] * [-1.0, 1.0] / start)
    if np.abs(across).max() > STRAIGHT * np.abs(velocity).max():
        return None

    def rates(_: float, at: Array) -> Array:
        force = row.force(max(float(at[1] - at[0]), touching), own, law) * np.array([-1.0, 1.0])
        reynolds = 2.0 * floats.radius * np.abs(at[2:]) * parameters.drift.thickness
        drag = friction * [schiller_naumann_factor(each) for each in reynolds.tolist()] * at[2:]
        return np.concatenate([at[2:], (force - drag) / floats.mass])

    def meet(_: float, at: Array) -> float:
        return float(at[1] - at[0]) - touching

    meet.terminal = True  # type: ignore[attr-defined]  # an attribute that SciPy reads
    begin = np.array([0.0, start, *speeds])
    found = solve_ivp(rates, (frames[0].time, frames[-1].time), begin, "LSODA", events=meet, rtol=1e-8, atol=1e-12)
    return np.stack([found.t, found.y[1] - found.y[0] - touching])


STRAIGHT = 1e-3
"""The largest velocity across the line of two floats, over their velocity, with which they stay on it."""


def _alone(scene: Any) -> bool:
    """Whether the floats of a scene move only by the pair law and the drag of single floats."""
    hydrodynamics, parts = scene.hydrodynamics, ("dish", "cell", "flow", "waves", "activity", "magnetic_field")
    coupled = hydrodynamics.lubrication is not None or hydrodynamics.interaction != "none"
    superposed = scene.interaction.method == "superposition" and not scene.shaped
    driven = hydrodynamics.brownian or any(getattr(scene, part) is not None for part in parts)
    magnets = any(one.magnetic_moment != 0.0 for one in scene.given)
    return superposed and not (coupled or driven or magnets or scene.user_laws)


def shapes(frames: Frames, scene: Any) -> Figure:
    """The rafts of the last frame: radius of gyration over number of floats, with the curve of a round, close-packed
    raft, and the fitted fractal dimension.
    """
    clusters = touching_clusters(frames[-1])
    found = shapes_of(frames[-1], clusters)
    several = clusters.sizes > 1
    if not several.any():
        raise BadInput("no floats are in contact in the last frame; no rafts to draw")
    radius = float(frames[-1].arrays["radius"].mean())
    sizes, gyration = clusters.sizes[several], found.gyration_radius[several] / radius
    # N discs at the density pi/sqrt(12) fill a circle of area 2 sqrt(3) N R^2; its radius of gyration is r/sqrt(2).
    round_ones = np.geomspace(2.0, sizes.max(), 50)
    with style():
        drawn = figure()
        axes = drawn.add_subplot(xlabel="floats in a raft", title=titled("Shapes of rafts", scene))
        long = np.minimum(found.elongation[several], 10.0)
        dots = axes.scatter(sizes, gyration, c=long, s=14, cmap="viridis", vmin=1.0, vmax=10.0)
        packed = np.sqrt(np.sqrt(3.0) / np.pi * round_ones)
        axes.plot(round_ones, packed, color=INK, label="round, close-packed")
        axes.plot(round_ones, np.sqrt((round_ones**2 - 1.0) / 3.0), "--", color=MUTED, label="a straight row")
        axes.set_ylabel("radius of gyration, in mean radii")
        axes.set(xscale=scaling([2.0, *sizes]), yscale=scaling(gyration))
        if len(np.unique(sizes)) > MOST_FOR_NO_FIT:
            fit = fractal_dimension(sizes, gyration)
            middle = np.exp(np.mean(np.log(gyration)) + np.log(round_ones / np.exp(np.mean(np.log(sizes)))) / fit.value)
            axes.plot(
                round_ones, middle, ":", color=PALETTE[0], label=f"fit, dimension {fit.value:.2f} ± {fit.error:.2f}"
            )
        if axes.get_xscale() == "log":
            axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
            axes.xaxis.set_major_formatter("{x:g}")
            axes.xaxis.set_minor_formatter(NullFormatter())
        else:
            axes.xaxis.set_major_locator(MaxNLocator(integer=True))
        drawn.colorbar(dots, ax=axes, label="elongation (10 and more)")
        axes.legend()
    return drawn


MEASURES = {
    "order": order,
    "pair-distribution": distribution,
    "displacement": displacement,
    "approach": approaches,
    "distance": distances,
    "shapes": shapes,
}
"""Figures by the names of `ecume plot --what`."""


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
    """The fractions of floats in rafts of one, two to three, four to seven floats and so on, over time; and the mean
    size of the raft of a float.
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
    """The most frequent topologies of clusters of at most ten floats over all frames: the frequency of each, with its
    contacts and symmetry number.
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
    """The transitions between arrangements of at most ten floats from frame to frame: the fraction of changes from each
    of the most frequent states to each other one, and the entropy production rate.
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
    """All frames, or the last `MOST_FRAMES` ones."""
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
    """A state without its single floats, whose number follows from that of all floats.

    >>> _short("1-0-0+1-0-0+3-3-7")
    '3-3-7'
    """
    several = [label for label in state.split("+") if not label.startswith("1-")]
    return "+".join(several) or "apart"


CLUSTER_FIGURES = {"raft-sizes": raft_sizes, "topologies": topology_figure, "transitions": transition_figure}
"""Figures by the names of `ecume plot --what`."""


FURTHEST = 6.0
"""The range of the force law, in capillary lengths."""


def paths(frames: Frames, scene: Any) -> Figure:
    """The path of every float, from an open circle to its last position, which is drawn to scale. In a periodic cell a
    path that leaves on one side continues on the opposite one.
    """
    shown = thinned(frames)
    view, kinds = view_of(scene, shown), species(scene)
    scale = scale_for(view.width / 2, "m")
    colors = [kinds[kind].color for kind in shown[-1].arrays["species"]]
    where = scale.factor * tracks(frames, instants(frames)).swapaxes(0, 1)
    lines, (begin, end) = list(where), (where[:, 0], where[:, -1])
    if scene.cell is not None:
        sides = scale.factor * np.asarray(scene.sides, float)
        lines = [piece for path in where for piece in pieces_of(path, sides)]
        begin, end = (at - sides * np.floor(at / sides) for at in (begin, end))
    with style():
        drawn = figure(5.4, 5.4 * min(max(view.height / view.width, 0.4), 1.6))
        axes = drawn.add_subplot(aspect="equal")
        axes.set(xlim=np.multiply(view[:2], scale.factor), ylim=np.multiply(view[2:], scale.factor))
        axes.set(xlabel=f"x ({scale.unit})", ylabel=f"y ({scale.unit})", title=titled("Paths", scene))
        axes.grid(visible=False)
        _discs(axes, end, scale.factor * shown[-1].arrays["radius"], colors)
        axes.add_collection(LineCollection(lines, colors=MUTED, linewidths=0.9, alpha=0.8))
        axes.scatter(begin[:, 0], begin[:, 1], s=9, facecolors="white", edgecolors=INK, linewidths=0.6, zorder=3)
        if scene.dish is not None:
            for patch in (dish_outline(scene.dish, scale.factor), *inner_walls(scene.dish, scale.factor)):
                axes.add_patch(patch)
        if len(kinds) > 1:
            axes.legend(handles=species_dots(kinds), loc="upper left", bbox_to_anchor=(1.01, 1.0), borderaxespad=0.0)
    return drawn


def pieces_of(path: Array, sides: Array) -> list[Array]:
    """The parts of a path (T, 2) in a cell with these sides, each in one image, with the point before and the one
    after it, so that lines reach the borders.

    >>> [piece.tolist() for piece in pieces_of(np.array([[0.5, 0.5], [1.5, 0.5]]), np.ones(2))]
    [[[0.5, 0.5], [1.5, 0.5]], [[-0.5, 0.5], [0.5, 0.5]]]
    """
    image = np.floor(path / sides)
    starts = [0, *(np.flatnonzero((np.diff(image, axis=0) != 0).any(axis=1)) + 1).tolist()]
    ends = [*starts[1:], len(path)]
    return [path[max(start - 1, 0) : end + 1] - image[start] * sides for start, end in zip(starts, ends, strict=True)]


class Pair(NamedTuple):
    """Two species and the force between them."""

    label: str
    touching: float
    force: Callable[[float], float]


def force_law(frames: Frames, scene: Any) -> Figure:
    """The force between two floats over their distance, for each pair of species; a dot where they touch."""
    row = PAIR_LAWS[str(scene.interaction.law)]
    if not (row.has_force and row.reciprocal):
        raise BadInput(f"the law between these floats is {scene.interaction.law!r}; no force to draw")
    length = liquid_of(scene).capillary_length
    pairs = _pairs(frames[0], scene, row)
    reach = max(FURTHEST * length, 1.5 * max(pair.touching for pair in pairs))
    with style():
        drawn = figure(6.4, 4.2)
        axes = drawn.add_subplot(xlabel="distance of the centers (mm)", title=titled("Force between two floats", scene))
        largest = max(abs(pair.force(pair.touching)) for pair in pairs)
        scale = scale_for(largest, "N")
        for pair, color in zip(pairs, itertools.cycle(PALETTE[1:]), strict=False):
            distance = np.linspace(pair.touching, reach, 300)
            force = np.array([pair.force(r) for r in distance.tolist()]) * scale.factor
            attracts = pair.force(pair.touching) < 0.0
            label = f"{plain(pair.label)}: {'attract' if attracts else 'repel'}"
            axes.plot(1e3 * distance, np.abs(force), "-" if attracts else "--", color=color, label=label)
            axes.plot(1e3 * distance[:1], np.abs(force[:1]), "o", color=color, markersize=5)
        axes.set(yscale="log", xlim=(0, 1e3 * reach), ylabel=f"force ({scale.unit})")
        unit = 1e3 * length
        lengths = (lambda mm: np.asarray(mm, float) / unit, lambda x: np.asarray(x, float) * unit)
        above = axes.secondary_xaxis("top", functions=lengths)
        above.set_xlabel("in capillary lengths")
        axes.legend()
    return drawn


def bowl(frames: Frames, scene: Any) -> Figure:
    """The last frame seen from above, with the height of the liquid."""
    picture = Bowl(scene, [frames[0], frames[-1]])
    picture.show(frames[-1])
    return picture.figure


def _discs(axes: Axes, centers: Array, radius: Array, colors: Sequence[str]) -> None:
    """Draw circles to scale."""
    look: dict[str, Any] = {"facecolors": colors, "edgecolors": INK, "linewidths": 0.6}
    look |= {"offsets": centers, "offset_transform": axes.transData}
    axes.add_collection(EllipseCollection(2 * radius, 2 * radius, 0 * radius, units="xy", **look))


def _pairs(frame: Frame, scene: Any, row: PairLaw) -> list[Pair]:
    """Each pair of species with a force between them, for the radii and charges that their floats have in the run."""
    arrays, liquid = frame.arrays, liquid_of(scene)
    length, tension = liquid.capillary_length, liquid.surface_tension
    kinds = [
        (kind.name, float(np.median(arrays["radius"][chosen])), float(np.median(arrays["charge"][chosen])))
        for index, kind in enumerate(species(scene))
        if (chosen := arrays["species"] == index).any()
    ]
    radii = [radius for _, radius, _ in kinds]
    law = constants_of(scene, Setting(length, tension, 2.0 * min(radii), FURTHEST * length + 2.0 * max(radii)))

    def force_of(own: PairParameters) -> Callable[[float], float]:
        return lambda distance: row.force(distance, own, law)

    found = [
        Pair(
            f"{a} – {b}",
            radius_a + radius_b,
            force_of(PairParameters(radius_a, radius_b, charge_a, charge_b, length, tension)),
        )
        for (a, radius_a, charge_a), (b, radius_b, charge_b) in itertools.combinations_with_replacement(kinds, 2)
    ]
    charged = [pair for pair in found if pair.force(pair.touching) != 0.0]
    if not charged:
        why = "these floats do not deform the surface"
        if not row.menisci:
            why = f"the law {str(scene.interaction.law)!r} exerts no force on these floats where they touch"
        raise BadInput(f"{why}; no force to draw")
    return charged


FLOATING_FIGURES = {
    "energies": energies,
    "kinetic-energy": kinetic_energy,
    "clusters": clusters,
    "paths": paths,
    "force-law": force_law,
    "bowl": bowl,
    **MEASURES,
    **CLUSTER_FIGURES,
}
