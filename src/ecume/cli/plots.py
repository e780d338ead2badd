"""The verb plot."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, NamedTuple

import typer

from ecume.cli.endings import say
from ecume.cli.options import argument, option
from ecume.cli.output import RESULTS, Out, echo, wrote
from ecume.cli.runs import HERE, Quiet
from ecume.cli.scenes import without_compiler_for
from ecume.errors import BadInput


def _figures(incomplete: str) -> list[str]:
    """Figures whose names begin with the incomplete word, for the shell's completion."""
    from ecume.show.figures import FIGURES

    known = dict.fromkeys(name for figures in FIGURES.values() for name in figures)
    return [name for name in known if name.startswith(incomplete)]


def length(text: str) -> float:
    """The length in a text from the command line: `86 mm`."""
    from ecume.units import parse

    try:
        found = parse(text, "m")
    except ValueError as fault:
        bare = "".join(text.split(".", 1)).isdecimal()
        raise typer.BadParameter(f"got {text} without a unit; write '{text} mm'" if bare else str(fault)) from None
    if not 0.01 <= found <= 2.0:
        raise typer.BadParameter(f"got {text}; expected 1 cm to 2 m")
    return found


What = Annotated[
    list[str] | None,
    option(
        "--what",
        metavar="NAME",
        help="Name of a figure, see --list, or number:NAME of frames; can be repeated. Default: all.",
        autocompletion=_figures,
    ),
]
Listed = Annotated[bool, typer.Option("--list", help="List the figures of the model of this run and draw none.")]
Verbose = Annotated[bool, typer.Option("--verbose", help="Report omitted figures and the reasons.")]
Integrators = Annotated[
    bool, typer.Option("--integrators", help="Compare the integrators; writes integrators.png and needs no run.")
]
ForceLaw = Annotated[
    Path | None,
    option(
        "--force-law",
        metavar="SCENE",
        help="Draw the forces between the floats of a scene by superposition, corrected pairs and multipoles "
        "into NAME-forces.png, and needs no run.",
    ),
]
Runs = Annotated[
    list[Path] | None,
    argument(
        metavar="[DIR]...",
        help="Directory of a run or a sweep; several runs, and tables (.csv) of an experiment, go into one figure. "
        "Default: the current directory.",
    ),
]
PictureFormat = Annotated[str, typer.Option("--format", metavar="png|pdf|svg", help="Format of figures in a folder.")]
FigureWidth = Annotated[Any, option("--width", parser=length, metavar="LENGTH", help="Width of the figure: '86 mm'.")]
NoTitle = Annotated[bool, typer.Option("--no-title", help="Omit titles.")]
DataFile = Annotated[Path | None, option("--data", metavar="FILE.csv", help="Also write the points of the curves.")]


def plot(
    directories: Runs = None,
    *,
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
        except BadInput as error:  # the run lacks data for this figure
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


VERBS = (plot,)
