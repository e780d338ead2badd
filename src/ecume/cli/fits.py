"""The verbs track and fit: parameters of a scene from measured tracks."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ecume.cli.endings import say
from ecume.cli.options import argument, option
from ecume.cli.output import echo, print_table, require_writable
from ecume.cli.runs import Quiet
from ecume.cli.scenes import Laws
from ecume.errors import BadInput

if TYPE_CHECKING:
    from ecume.fitting import Estimate, Fit

FITS = Path("fits")
"""The default parent folder of fits: `fits/beads` for `beads.csv`."""


def in_unit(text: str, unit: str, option: str) -> float:
    """A positive quantity from the command line, in this unit. Raises BadInput."""
    from ecume.units import Unit

    try:
        value = Unit(unit).number(float(text) if text.replace(".", "", 1).isdigit() else text)
    except ValueError as fault:
        raise BadInput(f"{option}: {fault}") from None
    if not value > 0.0:
        raise BadInput(f"{option}: got {text}; expected more than zero")
    return value


TrackFiles = Annotated[
    list[Path],
    argument(
        metavar="TRACKS",
        help="Tables of tracks: columns x, y, t, id, or the format of trackpy, TrackMate, MTrackJ or Tracker; "
        "Tracker writes a file for each object: give them all.",
    ),
]
SceneFile = Annotated[Path, option("--scene", metavar="SCENE", help="Scene to fit.")]
FreeKeys = Annotated[str, option("--free", metavar="KEY,KEY", help="Parameters to estimate, such as viscosity.")]
Pixel = Annotated[str | None, option("--pixel", metavar="SIZE", help="Size of a pixel: '20 um'.")]
Rate = Annotated[float | None, option("--rate", min=1e-6, max=1e9, metavar="N", help="Frames per second.")]
Origin = Annotated[
    tuple[float, float],
    typer.Option("--origin", metavar="X Y", help="Position of the scene's origin, in the units of the table."),
]
Only = Annotated[str | None, option("--only", metavar="ID,ID", help="Objects to use; default: all.")]
StartOf = Annotated[
    str,
    typer.Option(
        "--start",
        metavar="WHAT",
        help="Fitted part of the initial state: positions, moving (positions and velocities), or scene (none).",
    ),
]
Until = Annotated[
    float | None, option("--until", min=0.0, metavar="S", help="Ignore observations after this time (s).")
]
FitFolder = Annotated[
    Path | None, option("-o", "--out", metavar="DIR", help="Directory of the results; default: fits/NAME.")
]


FilmFile = Annotated[Path, argument(metavar="FILM", help="Film of the experiment.")]
Diameter = Annotated[str, option("--diameter", metavar="SIZE", help="Diameter of an object in pixels: '12 px'.")]
ObjectCount = Annotated[
    int | None, option("--count", min=1, metavar="N", help="Number of objects; default: all found.")
]
Dark = Annotated[bool, typer.Option("--dark", help="Objects are darker than the liquid.")]
Box = Annotated[
    tuple[int, int, int, int] | None,
    option("--box", metavar="LEFT TOP WIDTH HEIGHT", help="Part of the pictures to search, in pixels."),
]
TrackTable = Annotated[
    Path | None, option("-o", "--out", metavar="FILE.csv", help="Table of tracks; default: FILM.csv.")
]
OverlaidFilm = Annotated[
    Path | None, option("--film", metavar="FILM", help="Film of the tracks; the simulation is drawn on it.")
]


def track(
    film: FilmFile,
    *,
    diameter: Diameter,
    count: ObjectCount = None,
    dark: Dark = False,
    box: Box = None,
    rate: Rate = None,
    out: TrackTable = None,
    force: Annotated[bool, typer.Option("--force", help="Replace an existing table.")] = False,
    quiet: Quiet = False,
) -> None:
    """Track round objects in a film, for `ecume fit`.

    Positions are in pixels from the lower left corner, y upward. A film that is slower than reality needs --rate.

    Examples: `ecume track bowl.mp4 --diameter "12 px" --count 2`
    · `ecume track bowl.mp4 --diameter 31 --dark --box 100 80 640 480 --rate 120`
    """
    from ecume.fitting.films import Search, at_rest, film_tracks, table_of_tracks
    from ecume.trajectories.records import write_whole

    there = out or Path(f"{film.stem}.csv")
    if there.exists() and not force:
        raise BadInput(f"{there}: exists already; choose another name with -o, or replace it with --force")
    require_writable(there, there.parent)
    found = film_tracks(film, Search(_pixels(diameter), count, dark, box), rate)
    write_whole(there, table_of_tracks(found))
    if resting := at_rest(found, _pixels(diameter)):
        places = " and ".join(f"({x:.0f}, {y:.0f})" for x, y in resting[:3])
        say(
            f"warning: {film}: {len(resting)} of {found.position.shape[1]} objects do not move, at {places} px: parts "
            "of the picture such as a scale? --box restricts the search, --dark finds dark objects"
        )
    if not quiet:
        echo(f"{found.position.shape[1]} objects in {len(found.times)} pictures; wrote {there}")


def _pixels(text: str) -> float:
    """The number in a text from the command line: `12` or `12 px`. Raises BadInput."""
    word = text.strip().removesuffix("pixels").removesuffix("px").strip()
    try:
        return float(word)
    except ValueError:
        raise BadInput(f"--diameter: got {text!r}; expected a number of pixels such as '12 px'") from None


def fit(
    tracks: TrackFiles,
    *,
    scene: SceneFile,
    free: FreeKeys,
    pixel: Pixel = None,
    rate: Rate = None,
    origin: Origin = (0.0, 0.0),
    only: Only = None,
    start: StartOf = "positions",
    until: Until = None,
    laws: Laws = None,
    film: OverlaidFilm = None,
    out: FitFolder = None,
    quiet: Quiet = False,
) -> None:
    """Estimate parameters of a scene from measured tracks.

    Reports 95 % intervals, and what the tracks do not determine. Writes the fitted scene, the numbers and a figure of
    the residuals.

    Examples: `ecume fit beads.csv --scene two-spheres.toml --free contact_angle,viscosity`
    · `ecume fit spots.csv --scene two-spheres.toml --free viscosity --pixel "20 um" --rate 25`
    · `ecume fit bead-a.txt bead-b.txt --scene two-spheres.toml --free viscosity`
    · `ecume fit bowl.csv --scene two-spheres.toml --free surface_tension --pixel "20 um" --film bowl.mp4`
    """
    from ecume.fitting import Camera, picked, read_tracks
    from ecume.fitting import fit as fitted
    from ecume.run.user_code import laws_from
    from ecume.units import with_prefix

    camera = Camera(in_unit(pixel, "m", "--pixel") if pixel is not None else None, rate, origin)
    if film is not None and camera.pixel is None:
        raise BadInput("--film: needs --pixel, the size of a pixel, and a table in pixels as of `ecume track`")
    measured = read_tracks(tracks, camera)
    if only is not None:
        measured = picked(measured, _words(only))
    own, latest = laws_from(laws or []), math.inf if until is None else until
    directory = out or FITS / tracks[0].stem
    result = directory.absolute() / "fit.json"
    require_writable(result, next(folder for folder in result.parents if folder.exists()))
    found = fitted(measured, scene, _words(free), start=start, until=latest, extra_laws=own)
    keep(found, directory)
    if film is not None and camera.pixel is not None:
        from ecume.show.overlay import Scale, overlay

        drawn = overlay(film, found, Scale(camera.pixel, origin, rate), directory / "overlay.mp4")
        if not quiet:
            echo(f"wrote {drawn}")
    if not quiet:
        print_table(("", "value", "95 % interval", "unit"), map(_cells, [*found.estimates, *found.derived]))
        echo(f"noise: {with_prefix(found.noise, 'm', 3)}; {directory} contains the fitted scene and a figure")
    for remark in found.remarks:
        say(remark)


def _words(text: str) -> list[str]:
    return [word.strip() for word in text.split(",")]


def _cells(one: Estimate) -> tuple[str, str, str, str]:
    """A row of the table, rounded as the interval permits; angles in degrees."""
    if one.unit == "rad":
        value, low, high = (math.degrees(number) for number in (one.value, one.low, one.high))
        one = one._replace(value=value, low=low, high=high, unit="deg")
    if not one.determined or one.high == one.low:
        return one.name, f"{one.value:.4g}", "fixed" if one.determined else "not determined", one.unit
    digits = min(max(4, 2 - math.floor(math.log10((one.high - one.low) / abs(one.value)))), 9)
    return one.name, f"{one.value:.{digits}g}", f"{one.low:.{digits}g} to {one.high:.{digits}g}", one.unit


def keep(found: Fit, directory: Path) -> None:
    """Write the result of a fit: `fitted.toml`, `fit.json` and `residuals.png`."""
    from ecume.scenes.writing import to_toml
    from ecume.show.curves import fit_figure
    from ecume.show.style import save
    from ecume.trajectories.records import as_json, storing, write_whole

    with storing(directory):
        directory.mkdir(parents=True, exist_ok=True)
    write_whole(directory / "fitted.toml", to_toml(found.scene))
    write_whole(directory / "fit.json", as_json(plain_of(found)))
    save(fit_figure(found), directory / "residuals.png")


def plain_of(found: Fit) -> dict[str, Any]:
    """The numbers of a fit for JSON; undetermined parameters have no interval."""

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


VERBS = (track, fit)
