"""The common style of all pictures: fonts, lines, and colors suitable for color-blind readers."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple, cast

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import Colormap, LinearSegmentedColormap, to_hex, to_rgb
from matplotlib.figure import Figure

from ecume.errors import BadInput, StorageError
from ecume.scenes.common import PALETTE as PALETTE
from ecume.trajectories.records import replacing
from ecume.units import Array, prefix_power

INK, MUTED, RIM = "#1d2733", "#6b7785", "#39444f"
STEPS = 2048
"""Colors of a height scale: with 256 each step changes a channel by up to three of its 256 values, which shows as edges
on a smooth surface.
"""
HEIGHT_COLORS = LinearSegmentedColormap.from_list(
    "height", ["#8c4a1f", "#d99a63", "#f1d3b2", "#f6f7f5", "#b9d3e3", "#5d93bd", "#1f4e79"], STEPS
)

STYLE: dict[str, Any] = {
    "font.family": "DejaVu Sans",
    "font.size": 9.0,
    "axes.titlesize": 10.0,
    "axes.titlelocation": "left",
    "axes.labelcolor": INK,
    "axes.edgecolor": RIM,
    "axes.linewidth": 0.7,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#e4e8ec",
    "grid.linewidth": 0.6,
    "text.color": INK,
    "xtick.color": RIM,
    "ytick.color": RIM,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "xtick.major.width": 0.7,
    "ytick.major.width": 0.7,
    "lines.linewidth": 1.6,
    "lines.solid_capstyle": "round",
    "legend.frameon": False,
    "legend.fontsize": 8.5,
    "axes.formatter.use_mathtext": True,
    "axes.formatter.limits": (-3, 4),
    # Vector files contain text instead of outlines, and equal figures give equal files.
    "pdf.fonttype": 42,
    "svg.fonttype": "none",
    "svg.hashsalt": "ecume",
    "savefig.dpi": 200,
}

LIQUID_COLORS = {
    "water": "#4f9fd8",
    "seawater": "#3f8fb5",
    "milk": "#fbf8f0",
    "ethanol": "#b9d9ee",
    "glycerol": "#d8e6e4",
    "mercury": "#b3b8be",
    "soapy water": "#a5cbe3",
    "olive oil": "#b8a83a",
    "sunflower oil": "#edcf52",
    "honey": "#d98e1f",
    "coffee": "#4a2c1a",
    "syrup": "#c98a4b",
}
"""The colors of liquids by name."""
DARK_CANVAS = "#12181f"
"""The background of pages in dark mode."""
LEAST_CONTRAST = 2.0
"""The smallest contrast of a color with the dark background: the ratio of luminances (each plus 0.05) by WCAG."""


def luminance(color: Any) -> float:
    """The relative luminance of a color, from 0 to 1 (WCAG 2.2, sRGB)."""
    linear = [part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in to_rgb(color)]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def contrast(one: Any, other: Any) -> float:
    """The contrast of two colors, from 1 to 21 (WCAG 2.2).

    >>> round(contrast("black", "white"), 9)
    21.0
    """
    low, high = sorted((luminance(one), luminance(other)))
    return (high + 0.05) / (low + 0.05)


def seen_part(colors: Colormap, ground: str) -> tuple[float, float]:
    """The part of a colormap in which every color differs from the background by at least `LEAST_CONTRAST`."""
    steps = [place / 255 for place in range(256)]
    enough = [place for place in steps if contrast(colors(place)[:3], ground) >= LEAST_CONTRAST]
    return (enough[0], enough[-1]) if enough else (0.0, 1.0)


PREFIXES = ((-15, "f"), (-12, "p"), (-9, "n"), (-6, "µ"), (-3, "m"), (0, ""), (3, "k"), (6, "M"))


class Scale(NamedTuple):
    """A scale for an axis: the factor from the SI unit to the shown unit, and its name."""

    factor: float
    unit: str


def scale_for(largest: float, unit: str) -> Scale:
    """The prefix with which `largest` (in SI) is a number from 1 to 1000; for `m^2`, whose prefix is squared, from 0.01
    to 10,000. Units such as `kg` have none.

    >>> scale_for(0.0042, "m"), scale_for(0.002, "m^2"), scale_for(1000.0, "kg/m^3")
    (Scale(factor=1000.0, unit='mm'), Scale(factor=1000000.0, unit='mm^2'), Scale(factor=1.0, unit='kg/m^3'))
    """
    order = prefix_power(unit)
    least = 0.1**order if order > 1 else 1.0
    for power, prefix in PREFIXES if order else ():
        if abs(largest) < 0.9995 * least * 10.0 ** (order * (power + 3)) and largest != 0:
            return Scale(10.0 ** (-order * power), prefix + unit)
    return Scale(1.0, unit)


WARM, COOL, BLACK, WHITE = "#5a4630", "#34506e", "#0b1722", "#ffffff"
"""Tints of the lowest and the highest parts of bright and of dark liquids."""
TINTS = (0.75, 0.5, 0.25)


def liquid_color(liquid: Any) -> str | None:
    """The color of the liquid of a scene: `liquid.color`, or that of its name; None if it has neither."""
    given: str | None = getattr(liquid, "color", None) or LIQUID_COLORS.get(liquid.name)
    return given


def height_colormap(liquid: str | None = None) -> Colormap:
    """Colors of the height of a surface: at the level that of the liquid, or a neutral one by default. For a bright
    liquid low parts are warmer and high parts cooler; for a dark one they are darker and brighter.
    """
    if liquid is None:
        return HEIGHT_COLORS
    low, high = (WARM, COOL) if luminance(liquid) > 0.5 else (BLACK, WHITE)
    lower, higher = ([mixed(liquid, end, part) for part in TINTS] for end in (low, high))
    colors = [*lower, liquid, *reversed(higher)]
    return LinearSegmentedColormap.from_list("height", colors, STEPS)


def mixed(one: str, other: str, part: float) -> str:
    """A color mixed with a part of another.

    >>> mixed("#000000", "#ffffff", 0.2)
    '#333333'
    """
    both = zip(to_rgb(one), to_rgb(other), strict=True)
    red, green, blue = ((1.0 - part) * first + part * second for first, second in both)
    return str(to_hex((red, green, blue)))


def plain(text: str) -> str:
    """A user's text without special meaning of characters: `$` starts no formula, and an initial underscore hides no
    label.
    """
    shown = text.replace("$", r"\$")
    return " " + shown if shown.startswith("_") else shown


def figure(width: float = 6.4, height: float = 4.0) -> Figure:
    """An empty figure of this size (inches), independent of any screen and not registered in pyplot."""
    made = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(made)
    return made


@contextmanager
def style() -> Iterator[None]:
    """A context with ecume's style for figures, independent of the user's settings."""
    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(cast(Any, STYLE))
        yield


def save(drawn: Figure, out: Path) -> Path:
    """Write a figure in the format of its file name."""
    out = Path(out)
    known = drawn.canvas.get_supported_filetypes()
    if out.suffix[1:].lower() not in known:
        raise BadInput(
            f"{out.name}: no such kind of picture as {out.suffix!r}; expected one of .{', .'.join(sorted(known))}"
        )
    # With a date, the files of equal figures would differ.
    undated: dict[str, dict[str, None]] = {".pdf": {"CreationDate": None}, ".svg": {"Date": None}}
    kind = out.suffix[1:].lower()
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        with style(), replacing(out, settled=False) as file:
            drawn.savefig(file, format=kind, metadata=undated.get(f".{kind}"))
    except (OSError, StorageError) as error:
        why = getattr(error.__cause__ or error, "strerror", None)
        raise StorageError(f"{out}: cannot be written ({why or error})") from error
    return out


def binned(
    axes: Axes, values: Array, edges: Array, *, upward: bool = False, color: str | None = None, label: str | None = None
) -> None:
    """Draw a histogram as a curve, whose points are the beginnings of bins and the end of the last one; bins are along
    x, or with `upward` along y.
    """
    high = np.append(values, values[-1])
    if upward:
        axes.plot(high, edges, drawstyle="steps-pre", color=color, label=label)
    else:
        axes.plot(edges, high, drawstyle="steps-post", color=color, label=label)


def legend_outside(axes: Axes, title: str | None = None) -> None:
    """A legend to the right of the axes, where it hides no curve."""
    if axes.get_legend_handles_labels()[0]:
        axes.legend(loc="upper left", bbox_to_anchor=(1.01, 1.0), borderaxespad=0.0, title=title, alignment="left")
