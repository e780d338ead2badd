"""The verbs that make files of a run: movie, plot and export; and their options."""

from __future__ import annotations

import contextlib
import math
import re
import sys
import tempfile
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import typer

from ecume.cli.endings import say
from ecume.cli.output import echo
from ecume.cli.progress import counted
from ecume.cli.runs import HERE, Quiet, RunFolder
from ecume.cli.scenes import Overrides, placed, without_compiler, without_compiler_for
from ecume.errors import BadInput, beside_ecume, install

NUMBER = re.compile(r"\s*[+-]?[0-9]+\.?[0-9]*(?:[eE][+-]?[0-9]+)?\s*")


def _figures(incomplete: str) -> list[str]:
    """Figures whose names begin with the incomplete word, for the shell's completion."""
    from ecume.show.figures import FIGURES

    known = dict.fromkeys(name for figures in FIGURES.values() for name in figures)
    return [name for name in known if name.startswith(incomplete)]


def seconds(text: str) -> float:
    """The time in a text from the command line: `2.5`, `2 s`, `3 min`."""
    from ecume.units import parse

    try:
        return float(text) if NUMBER.fullmatch(text) else parse(text, "s")
    except ValueError as fault:
        raise typer.BadParameter(str(fault)) from None


def pixels(text: str) -> tuple[int, int]:
    """The size in a text from the command line: `1280x960`."""
    match = re.fullmatch(r"\s*([0-9]{1,6})\s*[x×]\s*([0-9]{1,6})\s*", text)
    if match is None:
        raise typer.BadParameter(f"got {text!r}; expected WIDTHxHEIGHT in pixels, such as 1280x960")
    return int(match[1]), int(match[2])


def length(text: str) -> float:
    """The length in a text from the command line: `86 mm`."""
    from ecume.units import parse

    try:
        found = parse(text, "m")
    except ValueError as fault:
        raise typer.BadParameter(str(fault)) from None
    if not 0.01 <= found <= 2.0:
        raise typer.BadParameter(f"got {text}; expected 1 cm to 2 m")
    return found


Out = Annotated[
    Path | None,
    typer.Option(
        "-o", "--out", metavar="FILE", help="Output file or folder; default: in DIR/results.", show_default=False
    ),
]
Fps = Annotated[int, typer.Option("--fps", metavar="N", help="Frames per second.")]
Speed = Annotated[
    float | None,
    typer.Option(
        "--speed", min=1e-9, metavar="X", help="Speed over real time; sets --fps and --every.", show_default=False
    ),
]
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
Listed = Annotated[bool, typer.Option("--list", help="List the figures of the model of this run and draw none.")]
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


TEXT = ("csv", "numbers", "samples", "xyz")
"""Text formats, which can be printed and piped."""


def to_stdout(directory: Path, kind: str) -> None:
    """Write the frames of a run to the standard output."""
    from ecume.trajectories.exports import export

    if kind not in TEXT:
        raise BadInput(f"-o -: {kind} is a binary format; expected one of {', '.join(TEXT)}, or the name of a file")
    with tempfile.TemporaryDirectory() as folder, export(directory, kind, Path(folder) / "frames").open("rb") as file:
        for part in iter(lambda: file.read(2**20), b""):
            sys.stdout.buffer.write(part)
        sys.stdout.buffer.flush()


def require_folder(file: Path) -> None:
    """Raise BadInput for a file in a folder that does not exist."""
    if not file.parent.is_dir():
        raise BadInput(f"-o {file}: the folder {file.parent} does not exist")


RESULTS = "results"
"""The folder of a run directory for movies, figures and exports."""


class Format(StrEnum):
    """The formats of an export: the keys of `ecume.trajectories.exports.EXPORTS`, `pvd`, heights, and decks."""

    CSV = "csv"
    NUMBERS = "numbers"
    SAMPLES = "samples"
    XYZ = "xyz"
    VTK = "vtk"
    PVD = "pvd"
    NPZ = "npz"
    HEIGHTS = "heights"
    HEIGHTS_VTK = "heights-vtk"
    RO_CRATE = "ro-crate"
    LAMMPS = "lammps"


Authors = Annotated[
    list[str] | None,
    typer.Option(
        "--author",
        metavar="NAME",
        help="Author of the run, with an ORCID if any, for ro-crate. Can be repeated.",
        show_default=False,
    ),
]
License = Annotated[
    str | None,
    typer.Option(
        "--license", metavar="ID", help="License of the run for ro-crate, such as CC-BY-4.0.", show_default=False
    ),
]
ENDINGS = {
    Format.CSV: ".csv",
    Format.NUMBERS: "-numbers.csv",
    Format.SAMPLES: "-samples.csv",
    Format.XYZ: ".xyz",
    Format.VTK: ".vtkhdf",
    Format.PVD: ".pvd",
    Format.NPZ: ".npz",
    Format.HEIGHTS: "-heights.npz",
    Format.HEIGHTS_VTK: "-heights.pvd",
}


def eye(azimuth: float | None, elevation: float | None) -> Any:
    """The viewpoint; None where neither angle was given."""
    from ecume.show.picture import Eye

    asked = {"azimuth": azimuth, "elevation": elevation}
    given = {name: angle for name, angle in asked.items() if angle is not None}
    return Eye(**given) if given else None


def movie(
    directory: RunFolder = HERE,
    out: Out = None,
    fps: Fps = 30,
    every: Every = 1,
    speed: Speed = None,
    size: PictureSize = None,
    start: Begin = None,
    end: End = None,
    color: Color = None,
    particles: Particles = False,
    zoom: Zoom = 1.0,
    follow: Follow = None,
    azimuth: Azimuth = None,
    elevation: Elevation = None,
    workers: Workers = 1,
    quiet: Quiet = False,
) -> None:
    """Make a movie of a run.

    The file name selects the format: .mp4, .webm, .webp or .gif, or .png for numbered pictures.

    Examples: `ecume movie runs/bowl` · `ecume movie runs/bowl -o bowl.gif --every 2 --fps 20 --size 480x360`
    · `ecume movie runs/bowl --from "1 s" --to "3 s"` · `ecume movie runs/bowl --follow 3 --zoom 4`
    · `ecume movie runs/bowl --speed 0.2` · `ecume movie runs/dam --color speed --azimuth 60`
    · `ecume movie runs/bowl -o shots.png --every 10`
    """
    from ecume.run.directory import existing

    existing(directory)
    without_compiler_for(directory)
    from ecume.show.movies import MovieOptions
    from ecume.show.movies import movie as make
    from ecume.show.picture import Aim

    if speed is not None:
        fps, every = pace(speed, frame_interval(directory))
    asked: dict[str, Any] = {"start": start, "end": end, "size": size, "color": color, "eye": eye(azimuth, elevation)}
    asked["aim"] = Aim(zoom, follow)
    given = {name: value for name, value in asked.items() if value is not None}
    options = MovieOptions(fps=fps, every=every, particles=particles, **given)
    with counted("pictures", quiet=quiet) as reporter:
        made = make(directory, out, options, progress=reporter, workers=workers)
    if made.suffix == ".png" and not quiet:
        pictures = sorted(made.parent.glob(f"{made.stem[:-4]}[0-9][0-9][0-9][0-9].png"))
        echo(f"wrote {len(pictures)} pictures, {made} to {pictures[-1].name}")
    else:
        wrote(made, quiet=quiet)
    if not quiet:
        with contextlib.suppress(BadInput):
            pace_text = f"{fps * every * frame_interval(directory):.3g} × real time"
            say(pace_text if speed is not None else f"{pace_text}; --speed sets it")
    if made.suffix != (out or Path("movie.mp4")).suffix and not quiet:
        say(f"no ffmpeg was found, so this is a WebP; for MP4 and WebM install ffmpeg, or {install('movie')}")


Runs = Annotated[
    list[Path] | None,
    typer.Argument(
        metavar="[DIR]...",
        help="Directory of a run or a sweep; several runs, and tables (.csv) of an experiment, go into one figure. "
        "Default: the current directory.",
        show_default=False,
    ),
]
PictureFormat = Annotated[str, typer.Option("--format", metavar="png|pdf|svg", help="Format of figures in a folder.")]
FigureWidth = Annotated[
    Any,
    typer.Option("--width", parser=length, metavar="LENGTH", help="Width of the figure: '86 mm'.", show_default=False),
]
NoTitle = Annotated[bool, typer.Option("--no-title", help="Omit titles.")]
DataFile = Annotated[
    Path | None,
    typer.Option("--data", metavar="FILE.csv", help="Also write the points of the curves.", show_default=False),
]


MOST_RATE = 60.0
"""The largest number of pictures per second of a movie with a given speed."""


def frame_interval(directory: Path) -> float:
    """The time between two frames of a run (s); zero for a single frame."""
    from ecume.trajectories.reader import open_trajectory

    with open_trajectory(directory) as trajectory:
        times = trajectory.times
    return float(times[-1] - times[0]) / (len(times) - 1) if len(times) > 1 else 0.0


def pace(speed: float, interval: float) -> tuple[int, int]:
    """The pictures per second of a movie with this speed over real time, and the number of frames from picture to
    picture.

    >>> pace(0.5, 0.02), pace(1.0, 0.001), pace(0.01, 0.002)
    ((25, 1), (59, 17), (5, 1))
    """
    if interval <= 0.0:
        return 30, 1
    rate = speed / interval
    every = max(1, math.ceil(rate / MOST_RATE))
    return max(1, round(rate / every)), every


def plot(
    directories: Runs = None,
    what: What = None,
    out: Out = None,
    form: PictureFormat = "png",
    width: FigureWidth = None,
    no_title: NoTitle = False,
    data: DataFile = None,
    integrators: Integrators = False,
    force_law: ForceLaw = None,
    listed: Listed = False,
    verbose: Verbose = False,
    quiet: Quiet = False,
) -> None:
    """Draw figures of a run or a sweep; default: all.

    For example energies, clusters, paths. The file name selects the format: .png, .pdf, .svg; of a folder, --format.

    Figures of a sweep: `curves`, `map` or `scatter` of the first measure; `map:duration` uses the measure `duration`.

    Examples: `ecume plot runs/bowl` · `ecume plot runs/bowl --list` · `ecume plot runs/bowl -o figures --format pdf`
    · `ecume plot runs/bowl --what paths -o paths.pdf --width "86 mm" --no-title --data paths.csv`
    · `ecume plot runs/coarse runs/fine experiment.csv --what gauges -o gauges.pdf`
    · `ecume plot runs/bowl --what number:contacts` · `ecume plot sweeps/durations --what curves:duration`
    · `ecume plot --integrators`
    · `ecume plot --force-law bowl.toml`
    """
    directory, *others = directories or [HERE]
    look = {"width": width, "title": not no_title}
    require_picture(out, form)
    if force_law is not None or integrators:
        _require_alone(force_law, integrators=integrators, of_a_run=bool(directories) or bool(what))
        wrote(_without_a_run(force_law, out), quiet=quiet)
    elif listed:
        _list(directory)
    elif (directory / "points.json").is_file():
        _draw_sweep(Asked([directory, *others], what or [], out, form, data), look, quiet=quiet)
    elif what or others or data:
        _draw(Asked([directory, *others], what or [], out, form, data), look, quiet=quiet)
    else:
        _draw_all(directory, _folder(out, directory), form, look, verbose=verbose, quiet=quiet)


PICTURE_KINDS = ("png", "pdf", "svg", "eps", "ps", "jpg", "jpeg", "tif", "tiff", "webp", "svgz", "pgf", "raw", "rgba")
"""The file name extensions of figures."""


def require_picture(out: Path | None, form: str) -> None:
    """Raise BadInput for a file or a format that figures cannot have, before anything is drawn."""
    if form not in PICTURE_KINDS:
        raise BadInput(f"--format: got {form!r}; expected one of png, pdf, svg")
    if out is not None and out.suffix and not out.is_dir() and out.suffix[1:].lower() not in PICTURE_KINDS:
        hint = "; --data writes the numbers of a figure" if out.suffix.lower() == ".csv" else ""
        raise BadInput(f"-o {out}: got the ending {out.suffix!r}; expected .png, .pdf or .svg, or a folder{hint}")


def _folder(out: Path | None, directory: Path) -> Path:
    """The folder for several figures. Raises BadInput for the name of a file."""
    if out is None:
        return directory / RESULTS
    if out.suffix and not out.is_dir():
        raise BadInput(f"-o {out}: a file holds one figure; name it with --what, or name a folder")
    return out


class Asked(NamedTuple):
    """The figures of a command."""

    sources: list[Path]
    """runs, and tables of experiments"""
    names: list[str]
    out: Path | None
    form: str
    data: Path | None


def _require_alone(force_law: Path | None, *, integrators: bool, of_a_run: bool) -> None:
    """Raise BadInput if a figure without a run is combined with a run, or with another such figure."""
    if force_law is not None and (integrators or of_a_run):
        raise BadInput("--force-law needs no run, no --what and no --integrators; it draws a scene's pairs")
    if integrators and of_a_run:
        raise BadInput("--integrators needs no run and no --what; it draws a built-in case of two spheres")


def _without_a_run(force_law: Path | None, out: Path | None) -> Path:
    """Draw the forces between a scene's floats, or the comparison of integrators."""
    if force_law is not None:
        from ecume.show.floating.law_figures import force_law as draw

        return draw(force_law, out or Path(f"{force_law.stem}-forces.png"))
    from ecume.show.floating.law_figures import integrator_comparison

    return integrator_comparison(out or Path("integrators.png"))


def _draw_sweep(asked: Asked, look: dict[str, Any], *, quiet: bool) -> None:
    """Draw figures of a sweep: `curves`, `map`, `scatter` or `fit`; `curves:duration` uses the measure `duration`."""
    from ecume.show.publishing import Finish
    from ecume.sweep.figures import kinds_of, plot_sweep

    directory, *others = asked.sources
    if others:
        raise BadInput(f"{directory} is a sweep, whose figures are drawn alone; got {others[0]} beside it")
    names = asked.names or kinds_of(directory)
    _require_one_table(names, asked.data)
    if _folder_of(asked.out) is None:
        _require_one(names, asked.out)
    for name in names:
        kind, _, measure = name.partition(":")
        finish = Finish(**look)
        made = plot_sweep(directory, kind, measure or None, asked.out, form=asked.form, finish=finish, data=asked.data)
        for path in made:
            wrote(path, quiet=quiet)


def _folder_of(out: Path | None) -> Path | None:
    """The folder for several figures; None for a file or nothing."""
    return out if out is not None and (out.is_dir() or not out.suffix) else None


def _require_one_table(names: list[str], data: Path | None) -> None:
    """Raise BadInput if one table is requested for the numbers of several figures."""
    if data is not None and len(names) > 1:
        raise BadInput(f"--data {data}: holds the numbers of one figure; give --what once")


TABLES = (".csv", ".tsv", ".txt")


def _draw(asked: Asked, look: dict[str, Any], *, quiet: bool) -> None:
    """Draw the requested figures, each for all runs and experiments together."""
    from ecume.run.directory import existing, manifest_of
    from ecume.show.figure_names import NUMBER, require_figure

    runs = [source for source in asked.sources if source.suffix.lower() not in TABLES or source.is_dir()]
    tables = [source for source in asked.sources if source not in runs]
    if not asked.names:
        raise BadInput("expected --what with the name of the figure; `ecume plot RUN --list` lists them")
    if not runs:
        raise BadInput("expected a run beside the table of an experiment")
    _require_one_table(asked.names, asked.data)
    for run in runs:
        model = str(manifest_of(existing(run)).get("model", ""))
        for name in asked.names:  # before the slow imports of what draws
            require_figure(model, name)
    if len(runs) == 1:
        without_compiler_for(runs[0])
    from ecume.show.figures import drawn_of
    from ecume.show.publishing import Finish, finished, read_measured, together, with_measured, written_data
    from ecume.show.style import save

    folder = _folder_of(asked.out)
    if folder is None:
        _require_one(asked.names, asked.out)
    for name in asked.names:
        figures = [(run.name or str(run), drawn_of(run, name)) for run in runs]
        drawn = together(figures) if len(figures) > 1 else figures[0][1]
        for table in tables:
            drawn = with_measured(drawn, read_measured(table))
        short = f"{name.removeprefix(NUMBER)}.{asked.form}"
        target = folder / short if folder is not None else asked.out or runs[0] / RESULTS / short
        if asked.data is not None:
            wrote(written_data(drawn, asked.data), quiet=quiet)
        wrote(save(finished(drawn, Finish(**look)), target), quiet=quiet)


def _require_one(names: list[str], out: Path | None) -> None:
    """Raise BadInput if one file is requested for several figures."""
    if out is not None and len(names) > 1:
        raise BadInput(f"{len(names)} figures do not fit into {out}; give --what once, or leave -o out")


def _draw_all(directory: Path, folder: Path, form: str, look: dict[str, Any], *, quiet: bool, verbose: bool) -> None:
    """Draw every figure for which the run has data, into a folder."""
    from ecume.run.directory import existing

    existing(directory)
    without_compiler_for(directory)
    from ecume.show.curves import ONE_FRAME
    from ecume.show.figures import figures_of_run
    from ecume.show.figures import plot as draw
    from ecume.show.publishing import Finish

    omitted = {}
    for name in figures_of_run(directory):
        try:
            drawn = draw(directory, name, folder / f"{name}.{form}", Finish(**look))
        except BadInput as error:  # no data for it
            omitted[name] = str(error)
        else:
            wrote(drawn, quiet=quiet)
    if verbose:
        for name, why in omitted.items():
            say(f"{name} omitted: {why}")
    elif any(why.startswith(ONE_FRAME) for why in omitted.values()):
        say(f"{ONE_FRAME} figures over time are omitted")


def _list(directory: Path) -> None:
    """Print the figures of a run or of a sweep."""
    if (directory / "points.json").is_file():
        from ecume.sweep.figures import kinds_of

        echo("\n".join(kinds_of(directory)))
        return
    from ecume.run.directory import existing
    from ecume.show.figures import described

    existing(directory)
    figures = described(directory)
    width = max(map(len, figures))
    for name, shows in figures.items():
        echo(f"{name:{width}}  {shows}")


RunOrScene = Annotated[
    Path,
    typer.Argument(
        metavar="DIR",
        help="Directory of a run, or a scene file for lammps; default: the current directory.",
        show_default=False,
    ),
]


def export(
    directory: RunOrScene = HERE,
    *,
    to: Annotated[
        Format,
        typer.Option(
            "--to",
            help="csv, xyz: text; numbers: CSV of energies, gauges ...; samples: numbers sampled between frames; "
            "vtk: ParaView (pvd: before 5.12); npz: NumPy; "
            "heights, heights-vtk: the surface around floats on a grid, for NumPy (.npz, or -o FILE.npy) and ParaView; "
            "ro-crate: metadata of the run in its directory; lammps: a scene as a folder with an input script.",
            show_default=False,
        ),
    ],
    out: Out = None,
    overrides: Overrides = None,
    authors: Authors = None,
    license_name: License = None,
    quiet: Quiet = False,
) -> None:
    """Write the frames of a run in another format, or a scene as input for LAMMPS. OVITO and HOOMD read the GSD files
    in DIR/traj directly.

    Examples: `ecume export runs/bowl --to csv` · `ecume export runs/bowl --to vtk -o bowl.vtkhdf` ·
    `ecume export runs/bowl --to numbers -o - | head` (text formats only) ·
    `ecume export bowl.toml --to lammps -o deck` ·
    `ecume export runs/bowl --to ro-crate --author "Ada Lovelace (0000-0002-1825-0097)" --license CC-BY-4.0`
    """
    from ecume.run.directory import existing
    from ecume.trajectories.exports import export as write

    if (authors or license_name) and to is not Format.RO_CRATE:
        raise BadInput("--author and --license are metadata of a run; use them with --to ro-crate")
    if overrides and to is not Format.LAMMPS:
        raise BadInput("--set changes a scene; use it with --to lammps")
    if to is Format.LAMMPS:
        wrote(_deck(directory, out, overrides or []), quiet=quiet)
        return
    existing(directory)
    if to is Format.RO_CRATE:
        wrote(_crate(directory, out, authors or [], license_name or ""), quiet=quiet)
        return
    if out == Path("-"):
        to_stdout(directory, to.value)
        return
    if out is not None:
        require_folder(out)
    path = out or directory / RESULTS / f"frames{ENDINGS[to]}"
    if to in (Format.HEIGHTS, Format.HEIGHTS_VTK):
        from ecume.show.floating.heights import export_heights

        wrote(export_heights(directory, path), quiet=quiet)
        return
    wrote(write(directory, to.value, path), quiet=quiet)


def _deck(scene: Path, out: Path | None, changes: list[str]) -> Path:
    """Write the deck of a scene file into a folder, `SCENE-lammps` by default."""
    from ecume.scenes.load import load_scene

    with beside_ecume():
        from ecume_lammps.decks import write_deck
    if out == Path("-"):
        raise BadInput("-o -: a deck is a folder; expected the name of one")
    if scene.is_dir():
        raise BadInput(f"--to lammps: got the folder {scene}; expected a scene file, which a deck is made of")
    asked = load_scene(scene, changes)
    folder = out or Path(f"{scene.stem}-lammps")
    require_folder(folder)
    without_compiler(asked)
    with placed(scene, changes):
        return write_deck(asked, folder)


def _crate(directory: Path, out: Path | None, authors: list[str], license_name: str) -> Path:
    """Add RO-Crate metadata to the directory of a run, in which the file names of the metadata are valid."""
    from ecume.run.research_object import Attribution, write_crate

    if out is not None:
        raise BadInput("-o: the metadata of a run are in its directory; omit -o, and copy or archive the directory")
    return write_crate(directory, Attribution(authors, license_name))


def wrote(path: Path, *, quiet: bool) -> None:
    """Print the path of a written file."""
    if not quiet:
        echo(f"wrote {path}")


VERBS = (movie, plot, export)
