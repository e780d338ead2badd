"""The verb fit: parameters of a scene from measured tracks."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ecume.cli.output import print_table, say
from ecume.cli.runs import Quiet
from ecume.errors import BadInput
from ecume.value_texts import with_prefix

if TYPE_CHECKING:
    from ecume.fitting import Estimate, Fit

FITS = Path("fits")
"""Where fits go by default: `fits/beads` for `beads.csv`."""


def in_unit(text: str, unit: str, option: str) -> float:
    """A positive quantity from the command line. Raises BadInput."""
    from ecume.units import Unit

    try:
        value = Unit(unit).number(float(text) if text.replace(".", "", 1).isdigit() else text)
    except ValueError as fault:
        raise BadInput(f"{option}: {fault}") from None
    if not value > 0.0:
        raise BadInput(f"{option}: got {text}; expected more than zero")
    return value


TrackFile = Annotated[
    Path,
    typer.Argument(
        metavar="TRACKS",
        help="Table of tracks: columns x, y, t, id, or the format of trackpy or TrackMate.",
        show_default=False,
    ),
]
SceneFile = Annotated[Path, typer.Option("--scene", metavar="SCENE", help="Scene to fit.", show_default=False)]
FreeKeys = Annotated[
    str,
    typer.Option("--free", metavar="KEY,KEY", help="Parameters to estimate, such as viscosity.", show_default=False),
]
Pixel = Annotated[
    str | None, typer.Option("--pixel", metavar="SIZE", help="Size of a pixel: '20 um'.", show_default=False)
]
Rate = Annotated[
    float | None, typer.Option("--rate", min=1e-6, max=1e9, metavar="N", help="Frames per second.", show_default=False)
]
Origin = Annotated[
    tuple[float, float],
    typer.Option("--origin", metavar="X Y", help="Position of the scene's origin, in the units of the table."),
]
Only = Annotated[
    str | None, typer.Option("--only", metavar="ID,ID", help="Objects to use; default: all.", show_default=False)
]
StartOf = Annotated[
    str,
    typer.Option(
        "--start",
        metavar="WHAT",
        help="Fitted part of the initial state: positions, moving (positions and velocities), or scene (none).",
    ),
]
Until = Annotated[
    float | None,
    typer.Option("--until", min=0.0, metavar="S", help="Ignore observations after this time (s).", show_default=False),
]
FitFolder = Annotated[
    Path | None,
    typer.Option(
        "-o", "--out", metavar="DIR", help="Directory of the results; default: fits/NAME.", show_default=False
    ),
]


def fit(
    tracks: TrackFile,
    scene: SceneFile,
    free: FreeKeys,
    pixel: Pixel = None,
    rate: Rate = None,
    origin: Origin = (0.0, 0.0),
    only: Only = None,
    start: StartOf = "positions",
    until: Until = None,
    out: FitFolder = None,
    quiet: Quiet = False,
) -> None:
    """Estimate parameters of a scene from measured tracks.

    Reports 95 % intervals, and what the tracks do not determine. Writes the fitted scene, the numbers and a figure of
    the residuals.

    Examples: `ecume fit beads.csv --scene two-spheres.toml --free contact_angle,viscosity`
    · `ecume fit spots.csv --scene two-spheres.toml --free viscosity --pixel "20 um" --rate 25`
    """
    from ecume.fitting import Camera, picked, read_tracks
    from ecume.fitting import fit as fitted

    camera = Camera(in_unit(pixel, "m", "--pixel") if pixel is not None else None, rate, origin)
    measured = read_tracks(tracks, camera)
    if only is not None:
        measured = picked(measured, _words(only))
    found = fitted(measured, scene, _words(free), start=start, until=math.inf if until is None else until)
    directory = out or FITS / tracks.stem
    keep(found, directory)
    if not quiet:
        print_table(("", "value", "95 % interval", "unit"), map(_cells, [*found.estimates, *found.derived]))
        typer.echo(f"noise: {with_prefix(found.noise, 'm', 3)}; {directory} contains the fitted scene and a figure")
    for remark in found.remarks:
        say(remark)


def _words(text: str) -> list[str]:
    return [word.strip() for word in text.split(",")]


def _cells(one: Estimate) -> tuple[str, str, str, str]:
    """A row of the table, with as many digits as its interval shows."""
    if not one.determined or one.high == one.low:
        return one.name, f"{one.value:.4g}", "fixed" if one.determined else "not determined", one.unit
    digits = min(max(4, 2 - math.floor(math.log10((one.high - one.low) / abs(one.value)))), 9)
    return one.name, f"{one.value:.{digits}g}", f"{one.low:.{digits}g} to {one.high:.{digits}g}", one.unit


def keep(found: Fit, directory: Path) -> None:
    """Write the result of a fit: `fitted.toml`, `fit.json` and `residuals.png`."""
    from ecume.scenes.writing import to_toml
    from ecume.show.fit_figures import fit_figure
    from ecume.show.style import save
    from ecume.trajectories.records import as_json, storing, write_whole

    with storing(directory):
        directory.mkdir(parents=True, exist_ok=True)
    write_whole(directory / "fitted.toml", to_toml(found.scene))
    write_whole(directory / "fit.json", as_json(plain_of(found)))
    save(fit_figure(found), directory / "residuals.png")


def plain_of(found: Fit) -> dict[str, Any]:
    """The numbers of a fit; what is undetermined has no interval."""

    def plain(one: Estimate) -> dict[str, Any]:
        interval = [one.low, one.high] if one.determined else None
        return {"name": one.name, "value": one.value, "interval": interval, "unit": one.unit}

    return {
        "estimates": [plain(one) for one in found.estimates],
        "derived": [plain(one) for one in found.derived],
        "noise": found.noise,
        "objects": list(found.tracks.names),
        "remarks": found.remarks,
        "rounds": found.rounds,
    }


VERBS = (fit,)
