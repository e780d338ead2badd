"""The verbs that run a scene many times: sweep, and fit, which finds parameters of a scene from measured tracks."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ecume.cli.endings import say
from ecume.cli.output import Json, echo, print_json, print_table
from ecume.cli.progress import counted, lasting
from ecume.cli.runs import Quiet, use_at_most
from ecume.cli.scenes import Laws
from ecume.errors import BadInput, Stopped

if TYPE_CHECKING:
    from ecume.fitting import Estimate, Fit
    from ecume.sweep import Outcome

SWEEPS = Path("sweeps")
"""The default parent folder of sweeps: `sweeps/durations` for `durations.toml`."""


def task_of(text: str) -> tuple[int, int]:
    """The number of a task and of all tasks of an array, from a text: `3/100`."""
    match = re.fullmatch(r"([0-9]{1,7})/([0-9]{1,7})", text)
    if match is None or not int(match[1]) < int(match[2]):
        raise typer.BadParameter(f"{text!r}: expected NUMBER/TASKS, such as 3/100")
    return int(match[1]), int(match[2])


def sweep(
    file: Annotated[Path, typer.Argument(metavar="SWEEP", help="File or directory of a sweep.", show_default=False)],
    out: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--out",
            metavar="DIR",
            help="Directory of the sweep; default: sweeps/NAME for NAME.toml.",
            show_default=False,
        ),
    ] = None,
    workers: Annotated[
        int | None,
        typer.Option(
            "--workers",
            min=1,
            max=4096,
            metavar="N",
            help="Number of workers; default: one per core.",
            show_default=False,
        ),
    ] = None,
    scheduler: Annotated[
        str | None,
        typer.Option("--scheduler", metavar="ADDRESS", help="Address of a running Dask scheduler.", show_default=False),
    ] = None,
    retries: Annotated[
        int, typer.Option("--retries", min=0, max=100, metavar="N", help="Retries of a point whose worker died.")
    ] = 2,
    slurm: Annotated[bool, typer.Option("--slurm", help="Run the workers as SLURM jobs.")] = False,
    array: Annotated[bool, typer.Option("--array", help="Write a job array for sbatch, and run nothing.")] = False,
    task: Annotated[Any, typer.Option("--task", parser=task_of, hidden=True)] = None,
    status: Annotated[bool, typer.Option("--status", help="Print the progress, and run nothing.")] = False,
    fit: Annotated[
        bool, typer.Option("--fit", help="Fit offset + K x^n to the first measure: table, figure and intervals.")
    ] = False,
    laws: Laws = None,
    json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Run a scene many times, each point in a separate directory.

    Finished points are not repeated.

    Examples: `ecume sweep durations.toml` · `ecume sweep durations.toml --workers 8`
    · `ecume sweep flow-curve.toml --fit` · `ecume sweep sweeps/durations --status`
    · `ecume sweep durations.toml --array && sbatch sweeps/durations/array.sh`
    """
    use_at_most(1)
    if sum((workers is not None, scheduler is not None, slurm, array, status)) > 1:
        raise BadInput("expected one of --workers, --scheduler, --slurm, --array and --status")
    if fit and (status or array or task is not None):
        raise BadInput("--fit is that of finished runs; expected it without --status and --array")
    if json and not status:
        raise BadInput("--json goes with --status")
    directory = out or (file if file.is_dir() else SWEEPS / file.stem)
    source = file / "sweep.toml" if file.is_dir() else file
    if status:
        _print_status(directory, json=json)
    elif task is not None:
        _work(directory, task, laws or [])
    elif array:
        _write_array(source, directory, absolute(laws or []))
    else:
        hands: dict[str, Any] = {"workers": workers, "scheduler": scheduler, "slurm": slurm, "retries": retries}
        hands["laws"] = tuple(absolute(laws or []))
        _run_all(source, directory, hands, quiet=quiet)
        if fit:
            _fit_all(directory, quiet=quiet)


def absolute(laws: Sequence[str]) -> list[str]:
    """The user's law files as absolute paths, which workers find from any folder."""
    return [str(Path(law).absolute()) for law in laws]


def _write_array(source: Path, directory: Path, laws: Sequence[str]) -> None:
    from ecume.run.user_code import entries, laws_from
    from ecume.sweep.directory import open_or_create
    from ecume.sweep.executors import write_array

    sweeping = open_or_create(source, directory, entries(laws_from(laws)))
    echo(f"wrote {write_array(sweeping, laws)}; submit it with sbatch")


def _run_all(source: Path, directory: Path, hands: dict[str, Any], *, quiet: bool) -> None:
    """Run the missing points, and report their results."""
    from ecume.sweep import ExecutorOptions, results

    def failed(folder: Path, why: str) -> None:
        say(f"{folder}: {why}")

    with counted("points", quiet=quiet, lines=True) as reporter:
        done = results.sweep(source, directory, ExecutorOptions(**hands, progress=reporter, failed=failed))
    _end(done, quiet=quiet)


def _fit_all(directory: Path, *, quiet: bool) -> None:
    """Draw and write the fit of the first measure, and print its parameters with their intervals; of two curves, also
    where they differ most.
    """
    import numpy as np

    from ecume.sweep.figures import fitted_curves, plot_sweep
    from ecume.sweep.fits import PARAMETERS, fit_of, largest_difference

    (picture,) = plot_sweep(directory, "fit")
    measure, curves = fitted_curves(directory)
    if quiet:
        return
    rows = []
    for points in curves:
        found, name = fit_of(points), points.label or measure
        for parameter in PARAMETERS:
            value, error = getattr(found, parameter)
            half = points.width * error
            rows.append((name, parameter, f"{value:.4g}", f"{value - half:.4g} to {value + half:.4g}"))
        rows.append((name, "misfit", f"{found.misfit:.3g}", "1 where curve and errors are right"))
    print_table(("curve", "of offset + factor x^exponent", "value", "95 % interval"), rows)
    omitted = sum(points.omitted for points in curves)
    if omitted:
        say(f"{omitted} runs are omitted: {measure} is not stationary there, or not a number; run these for longer")
    if len(curves) == 2 and np.intersect1d(curves[0].at, curves[1].at).size:
        apart = largest_difference(*curves)
        said = f"{100.0 * apart.relative:+.2g} %, {apart.errors:.2g} standard errors"
        echo(f"{curves[1].label} differs from {curves[0].label} most at {apart.at:.4g}: by {said}")
    echo(f"wrote {picture} and {picture.with_suffix('.csv')}")


def _end(done: Outcome, *, quiet: bool) -> None:
    """Report the outcome of a sweep. The exit code is 1 if points failed."""
    if not quiet:
        busy = f", {done.busy} elsewhere at work" if done.busy else ""
        echo(f"{done.directory}: {done.done} points done, {len(done.failed)} failed{busy}; table.csv has them all")
    if done.lost:
        raise Stopped(
            f"{done.lost} of the points are missing: their workers died again and again, of too little memory perhaps; "
            "finished points are kept; the same command continues the sweep"
        )
    if done.failed:
        raise typer.Exit(1)


def _print_status(directory: Path, *, json: bool) -> None:
    from ecume.sweep.directory import standing

    now = standing(directory)
    if json:
        print_json(now._asdict())
        return
    left = f"; {lasting(now.remaining)} left at the pace of the last points" if now.remaining is not None else ""
    echo(f"{directory}: {now.done} done, {len(now.failed)} failed, {now.running} running, {now.missing} missing{left}")
    for folder, why in now.failed:
        say(f"{folder}: {why}")


def _work(directory: Path, task: tuple[int, int], laws: Sequence[str]) -> None:
    """Run a task of a job array."""
    from ecume.sweep.directory import existing_sweep
    from ecume.sweep.executors import work_task

    words = work_task(existing_sweep(directory), *task, laws)
    if "failed" in words:
        raise BadInput(f"{words.count('failed')} of {len(words)} points failed; see ecume sweep {directory} --status")


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
    typer.Argument(
        metavar="TRACKS",
        help="Tables of tracks: columns x, y, t, id, or the format of trackpy, TrackMate, MTrackJ or Tracker; "
        "Tracker writes a file for each object: give them all.",
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


FilmFile = Annotated[Path, typer.Argument(metavar="FILM", help="Film of the experiment.", show_default=False)]
Diameter = Annotated[
    str,
    typer.Option("--diameter", metavar="SIZE", help="Diameter of an object in pixels: '12 px'.", show_default=False),
]
ObjectCount = Annotated[
    int | None,
    typer.Option("--count", min=1, metavar="N", help="Number of objects; default: all found.", show_default=False),
]
Dark = Annotated[bool, typer.Option("--dark", help="Objects are darker than the liquid.")]
Box = Annotated[
    tuple[int, int, int, int] | None,
    typer.Option(
        "--box", metavar="LEFT TOP WIDTH HEIGHT", help="Part of the pictures to search, in pixels.", show_default=False
    ),
]
TrackTable = Annotated[
    Path | None,
    typer.Option("-o", "--out", metavar="FILE.csv", help="Table of tracks; default: FILM.csv.", show_default=False),
]
OverlaidFilm = Annotated[
    Path | None,
    typer.Option(
        "--film", metavar="FILM", help="Film of the tracks; the simulation is drawn on it.", show_default=False
    ),
]


def track(
    film: FilmFile,
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
    from ecume.fitting.films import Search, film_tracks, table_of_tracks
    from ecume.trajectories.records import write_whole

    there = out or Path(f"{film.stem}.csv")
    if there.exists() and not force:
        raise BadInput(f"{there}: exists already; choose another name with -o, or replace it with --force")
    found = film_tracks(film, Search(_pixels(diameter), count, dark, box), rate)
    write_whole(there, table_of_tracks(found))
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
    found = fitted(measured, scene, _words(free), start=start, until=latest, extra_laws=own)
    directory = out or FITS / tracks[0].stem
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


VERBS = (sweep, track, fit)
