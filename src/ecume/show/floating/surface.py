"""The liquid's height around floats on the pixels of a picture.

Floats with a shape, in pictures: their outlines as they are turned, and the charges that bend the surface.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from numpy.typing import NDArray

from ecume.analysis.boxes import box_of, copies
from ecume.laws.pair_laws import PAIR_LAWS
from ecume.laws.radiated_waves import Complexes, ripples, surface_per_force
from ecume.laws.special import bessel_k0
from ecume.models.floating.dishes import field_of
from ecume.models.liquids import liquid_of
from ecume.show.picture import Species, View
from ecume.show.style import INK
from ecume.trajectories.frame import Frame
from ecume.units import Array


class Shapes(NamedTuple):
    """The shapes of all floats of a scene, each in the frame of its body."""

    outlines: list[Array]
    """of each float (points, 2)"""
    place: Array
    """(P, 2) of the charges (m)"""
    charge: Array
    """(P,) m"""
    owner: Array
    """(P,) the float of each charge"""
    rise: float
    """the highest that a contact line rises or dips (m)"""


def shapes_of(scene: Any) -> Shapes | None:
    """The shapes of a scene's floats; None if all are round."""
    if not scene.shaped:
        return None
    from ecume.models.floating.setup.kinds import distinct_kinds
    from ecume.models.floating.shaped.shapes import charges_of, silhouette

    kinds, number = distinct_kinds(scene)
    outlines = [silhouette(kind.figure.skeleton) for kind in kinds]
    spread = [charges_of(kind.figure) for kind in kinds]
    return Shapes(
        outlines=[outlines[kind] for kind in number],
        place=np.concatenate([spread[kind][0] for kind in number]),
        charge=np.concatenate([spread[kind][1] for kind in number]),
        owner=np.repeat(np.arange(len(number)), [len(spread[kind][1]) for kind in number]),
        rise=max(abs(kind.figure.line.rise) for kind in kinds),
    )


def turned(points: Array, angle: Array) -> Array:
    """Points of a float's own frame, rotated: one angle for all, or one for each."""
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * points[:, 0] - s * points[:, 1], s * points[:, 0] + c * points[:, 1]], axis=1)


def outlines_in(frame: Frame, shapes: Shapes) -> list[Array]:
    """The outlines of the floats in a frame."""
    arrays = frame.arrays
    each = zip(shapes.outlines, arrays["angle"], arrays["position"], strict=True)
    return [turned(outline, angle) + place for outline, angle, place in each]


def charges_in(frame: Frame, shapes: Shapes, margin: float) -> tuple[Array, Array]:
    """The positions (P, 2) of the charges in a frame, with their images less than a margin (m) outside a periodic
    cell, and the charges (m).
    """
    angle, position = frame.arrays["angle"][shapes.owner], frame.arrays["position"][shapes.owner]
    around = copies(turned(shapes.place, angle) + position, box_of(frame), margin)
    return around.position, shapes.charge[around.owner]


def polygons(axes: Axes, frame: Frame, shapes: Shapes, kinds: Sequence[Species]) -> PolyCollection:
    """Draw the floats of a frame to scale."""
    found = PolyCollection(
        outlines_in(frame, shapes),
        facecolors=[kinds[kind].color for kind in frame.arrays["species"]],
        edgecolors=INK,
        linewidths=0.6,
        zorder=2,
    )
    axes.add_collection(found, autolim=False)
    return found


CUTOFF = 7.0
"""The range of a meniscus in capillary lengths, where it is below a thousandth of its value at one capillary length."""
FADES = 0.7
"""The distance at which menisci begin to fade out, over their range."""
SAMPLES, MOST_SAMPLES = 32, 20_000
"""The number of nodes of the waves per wavelength, and the largest total number."""
NODES = 8000
INSIDE = 0.1
"""The smallest distance from a charge inside a contact line for its meniscus, over the float's radius."""
SOLVED_CELLS = 100
"""At most along a side where each cell sums all multipoles: some 20 ms a frame of 13 discs."""

Heights = NDArray[np.float32]


class WavePattern(NamedTuple):
    """The waves that oscillating floats radiate, at the instant of a stroboscope."""

    owner: Array
    """(M,) the float of each source"""
    place: Array
    """(M, 2) m, in the frame of the float"""
    press: Complexes
    """(M,) N: the complex force on the liquid"""
    distance: Array
    """(K,) m"""
    height: Complexes
    """(K,) m/N: the complex height at these distances from a unit force"""


class Sheet(NamedTuple):
    """A grid over the surface, the height that the dish gives it, and one float's meniscus per charge as a table."""

    x: Array
    y: Array
    still: Heights
    closest: float
    reach: float
    menisci: Heights
    """The height around a charge of one, at equal steps of distance from `closest` to `reach`, where it ends in a 0."""
    multipoles: Any = None
    """the floating model's parameters, where floats go by multipoles"""
    scene: Any = None
    """the scene, where a barrier moves the menisci of the dish"""
    shapes: Shapes | None = None
    """charges inside their contact lines, where floats have shapes"""
    waves: WavePattern | None = None


def sheet(scene: Any, view: View, *, cells: int, closest: float) -> Sheet:
    """A grid of about `cells` by `cells` squares; `closest` is the smallest distance from a float's center (m)."""
    liquid, multipoles, shapes = liquid_of(scene), multipoles_in(scene), shapes_of(scene)
    closest *= 1.0 if shapes is None else INSIDE
    cells = cells if multipoles is None else min(cells, SOLVED_CELLS)
    cell = max(view.width, view.height) / cells
    x = np.arange(view.left + cell / 2, view.right, cell)
    y = np.arange(view.bottom + cell / 2, view.top, cell)
    reach = max(CUTOFF * liquid.capillary_length, 1.01 * closest)
    table = _menisci(closest, reach, liquid.capillary_length)
    if not has_menisci(scene):
        table = np.zeros_like(table)
    still = np.asarray(field_of(scene.dish, liquid, x, y), np.float32)
    barred = scene if scene.dish is not None and scene.dish.barrier is not None else None
    return Sheet(x, y, still, closest, reach, table, multipoles, barred, shapes, wave_pattern(scene, view))


def has_menisci(scene: Any) -> bool:
    """Whether the floats of a scene interact by menisci: by the pair law or by a method."""
    row = PAIR_LAWS.get(scene.interaction.law)
    return scene.interaction.method == "multipole" or row is None or row.menisci or row.has_force


def wave_pattern(scene: Any, view: View) -> WavePattern | None:
    """The waves of a scene, if its floats oscillate."""
    if scene.waves is None:
        return None
    from ecume.models import MODELS
    from ecume.models.floating.forces.waves import Waves
    from ecume.models.floating.parameters import part_of

    with warnings.catch_warnings():
        # The run has already reported its time step.
        warnings.simplefilter("ignore")
        part = part_of(MODELS["floating"].parameters(scene), Waves)
    liquid = liquid_of(scene)
    found = ripples(scene.waves.frequency, liquid.density, liquid.surface_tension, liquid.viscosity, scene.gravity)
    far = np.hypot(view.width, view.height)
    distance = np.linspace(0.0, far, int(min(SAMPLES * far / found.wavelength, MOST_SAMPLES)) + 2)
    # The wave of a point source diverges at the source: at shorter distances it is not that of a float.
    distance[0] = 0.5 * distance[1]
    height = -surface_per_force(distance, found)
    return WavePattern(part.owner, part.place, part.press[:, 0] + 1j * part.press[:, 1], distance, height)


def wave_heights(frame: Frame, on: Sheet) -> Array:
    """The height of the waves (m) at the phase zero of all sources, shape (y, x)."""
    waves = on.waves
    if waves is None:
        return np.zeros((1, 1))
    spots = turned(waves.place, frame.arrays["angle"][waves.owner]) + frame.arrays["position"][waves.owner]
    total = np.zeros((len(on.y), len(on.x)))
    for (x, y), press in zip(spots, waves.press, strict=True):
        distance = np.hypot(on.x - x, (on.y - y)[:, None])
        total += np.interp(distance, waves.distance, (press * waves.height).real)
    return total


def multipoles_in(scene: Any) -> Any:
    """The model's parameters, if its floats interact by multipoles; otherwise None."""
    if scene.interaction.method != "multipole":
        return None
    from ecume.models import MODELS

    with warnings.catch_warnings():
        # The run has already reported its time step.
        warnings.simplefilter("ignore")
        return MODELS["floating"].parameters(scene)


def _menisci(closest: float, reach: float, length: float) -> Heights:
    """The far field of a unit charge, which determines the attraction, from a table, since a frame needs about 60 of
    them.
    """
    # The law is evaluated at the nodes of a table with linear interpolation, which needs far fewer evaluations.
    exact = np.geomspace(closest, reach, NODES // 16)
    heights = np.array([-bessel_k0(distance / length) for distance in exact])
    # Faded out, so that the end of a meniscus is not visible as a circle.
    share = np.clip((exact / reach - FADES) / (1.0 - FADES), 0.0, 1.0)
    heights *= 1.0 - share**2 * (3.0 - 2.0 * share)
    return np.array([*np.interp(np.linspace(closest, reach, NODES), exact, heights), 0.0], np.float32)


def unit_meniscus(on: Sheet, distance: Array) -> Heights:
    """The height around a unit charge (m/m), from the table: accurate to 0.1 % of its value at the closest distance."""
    per_meter = (NODES - 1) / (on.reach - on.closest)
    index = ((distance - on.closest) * per_meter + 0.5).astype(np.int32)
    return on.menisci[np.clip(index, 0, NODES)]


def surface(frame: Frame, on: Sheet) -> Heights:
    """The height of the surface (m) in one instant, shape (y, x); under a float, the height at its edge."""
    if on.multipoles is not None:
        return _solved_surface(frame, on)
    height = on.still.copy()
    if on.scene is not None:
        place = frame.numbers.get("barrier_position", 0.0)
        height = field_of(on.scene.dish, liquid_of(on.scene), on.x, on.y, place).astype(np.float32)
    if on.waves is not None:
        height += wave_heights(frame, on).astype(np.float32)
    if not on.menisci.any():
        return height
    arrays = with_images(frame, on.reach).arrays
    menisci = zip(arrays["position"], arrays["radius"], arrays["charge"], strict=True)
    if on.shapes is not None:
        places, charges = charges_in(frame, on.shapes, on.reach)
        menisci = zip(places, np.full(len(charges), on.closest), charges, strict=True)
    for (px, py), radius, charge in menisci:
        rows, columns = near(on.y, py, on.reach), near(on.x, px, on.reach)
        r = np.sqrt((on.x[columns] - px) ** 2 + ((on.y[rows] - py) ** 2)[:, None])
        height[rows, columns] += np.float32(charge) * unit_meniscus(on, np.maximum(r, radius))
    return height


def with_images(frame: Frame, margin: float) -> Frame:
    """The frame with the images of all floats less than a margin (m) outside a periodic cell; without a cell as it is.

    The floats themselves come first.
    """
    box = box_of(frame)
    if box is None:
        return frame
    around = copies(frame.arrays["position"], box, margin)
    arrays = {name: array[around.owner] for name, array in frame.arrays.items()}
    return frame._replace(arrays=arrays | {"position": around.position})


def _solved_surface(frame: Frame, on: Sheet) -> Heights:
    """The surface from multipoles; beyond a round wall it has the value at the wall, since the solution is valid only
    inside.
    """
    return np.asarray(on.still + solved_heights(on.multipoles, frame, on.x, on.y), np.float32)


def solved_heights(multipoles: Any, frame: Frame, x: Array, y: Array) -> Array:
    """The contribution of the solver's floats to the meniscus of the walls (m), shape (y, x)."""
    from ecume.models.floating.forces.multipoles import heights_at, multipoles_in, solved

    across, along = (grid.ravel() for grid in np.meshgrid(x, y))
    inside = np.minimum(1.0, multipoles.walls.disc_radius / np.maximum(np.hypot(across, along), 1e-300))
    places = np.stack([inside * across, inside * along], axis=1)
    return heights_at(multipoles_in(multipoles), solved(multipoles, frame), places).reshape(len(y), len(x))


def typical_meniscus(frame: Frame, on: Sheet) -> float:
    """The deformation of the surface at the edge of a typical float (m)."""
    if on.multipoles is not None:
        from ecume.models.floating.forces.multipoles import bends, multipoles_in, solved

        return float(np.median(bends(multipoles_in(on.multipoles), solved(on.multipoles, frame))))
    alone = float(np.median(np.abs(frame.arrays["charge"] * unit_meniscus(on, frame.arrays["radius"]))))
    return alone if on.shapes is None else max(alone, on.shapes.rise)


def near(nodes: Array, center: float, reach: float) -> slice:
    """The range of nodes within `reach` of `center`."""
    first, last = np.searchsorted(nodes, (center - reach, center + reach))
    return slice(int(first), int(last))
