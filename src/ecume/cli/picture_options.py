"""The options of movie and plot, and how their values are read."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Annotated, Any

import typer

NUMBER = re.compile(r"\s*[+-]?[0-9]+\.?[0-9]*(?:[eE][+-]?[0-9]+)?\s*")


def _figures(incomplete: str) -> list[str]:
    """Figures that begin so, for the shell's completion."""
    from ecume.show.figures import FIGURES

    known = dict.fromkeys(name for figures in FIGURES.values() for name in figures)
    return [name for name in known if name.startswith(incomplete)]


def seconds(text: str) -> float:
    """A time from the command line: `2.5`, `2 s`, `3 min`."""
    from ecume.units import parse

    try:
        return float(text) if NUMBER.fullmatch(text) else parse(text, "s")
    except ValueError as fault:
        raise typer.BadParameter(str(fault)) from None


def pixels(text: str) -> tuple[int, int]:
    """A size from the command line: `1280x960`."""
    match = re.fullmatch(r"\s*([0-9]{1,6})\s*[x×]\s*([0-9]{1,6})\s*", text)
    if match is None:
        raise typer.BadParameter(f"got {text!r}; expected WIDTHxHEIGHT in pixels, such as 1280x960")
    return int(match[1]), int(match[2])


Out = Annotated[
    Path | None,
    typer.Option(
        "-o", "--out", metavar="FILE", help="Output file or folder; default: in DIR/results.", show_default=False
    ),
]
Fps = Annotated[int, typer.Option("--fps", metavar="N", help="Frames per second.")]
Every = Annotated[int, typer.Option("--every", metavar="N", help="Use every N-th frame of the run.")]
PictureSize = Annotated[
    Any,
    typer.Option(
        "--size",
        parser=pixels,
        metavar="WxH",
        help="Size of the picture in pixels; default: 960x720, 640x480 for a GIF.",
        show_default=False,
    ),
]
Begin = Annotated[
    Any,
    typer.Option("--from", parser=seconds, metavar="TIME", help="Start time: 2.5 or '2.5 s'.", show_default=False),
]
End = Annotated[Any, typer.Option("--to", parser=seconds, metavar="TIME", help="End time.", show_default=False)]
Color = Annotated[
    str | None,
    typer.Option(
        "--color",
        metavar="WHAT",
        help="Color a liquid by pressure, dynamic-pressure, absolute-pressure, speed, density or region.",
        show_default=False,
    ),
]
Particles = Annotated[
    bool, typer.Option("--particles", help="Draw the particles of a liquid instead of a continuous surface.")
]
Zoom = Annotated[float, typer.Option("--zoom", metavar="Z", help="Zoom factor.")]
Follow = Annotated[
    int | None,
    typer.Option(
        "--follow", metavar="N", help="Center the picture on particle N (the first is 0).", show_default=False
    ),
]
Azimuth = Annotated[
    float | None,
    typer.Option("--azimuth", metavar="DEGREES", help="Azimuth of the camera (3D).", show_default=False),
]
Elevation = Annotated[
    float | None,
    typer.Option("--elevation", metavar="DEGREES", help="Elevation of the camera (3D).", show_default=False),
]
Workers = Annotated[int, typer.Option("--workers", metavar="N", help="Number of drawing processes.")]
What = Annotated[
    list[str] | None,
    typer.Option(
        "--what",
        metavar="NAME",
        help="Name of a figure, see --list, or number:NAME of frames; can be repeated. Default: all.",
        autocompletion=_figures,
        show_default=False,
    ),
]
Listed = Annotated[bool, typer.Option("--list", help="List the figures of this run and draw none.")]
Verbose = Annotated[bool, typer.Option("--verbose", help="Report omitted figures and the reasons.")]
Integrators = Annotated[
    bool, typer.Option("--integrators", help="Compare the integrators; writes integrators.png and needs no run.")
]
ForceLaw = Annotated[
    Path | None,
    typer.Option(
        "--force-law",
        metavar="SCENE",
        help="Draw the forces between the floats of a scene by superposition, corrected pairs and multipoles "
        "into NAME-forces.png, and needs no run.",
        show_default=False,
    ),
]
