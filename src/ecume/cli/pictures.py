"""Verbs that make files of a run: movie, plot, export."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from ecume.cli.ends import say
from ecume.cli.runs import RunFolder
from ecume.errors import BadInput

Out = Annotated[
    Path | None,
    typer.Option("-o", "--out", metavar="FILE", help="Where to write it; left out, in DIR.", show_default=False),
]


class Format(StrEnum):
    """What a trajectory can be written as: the keys of `ecume.trajectories.exports.EXPORTS`."""

    CSV = "csv"
    XYZ = "xyz"
    VTK = "vtk"
    NPZ = "npz"


ENDINGS = {Format.CSV: ".csv", Format.XYZ: ".xyz", Format.VTK: ".vtkhdf", Format.NPZ: ".npz"}


def _figures(incomplete: str) -> list[str]:
    """Figures that begin so, for the shell's completion."""
    from ecume.show.figures import FIGURES

    return [name for name in FIGURES if name.startswith(incomplete)]


def movie(directory: RunFolder, out: Out = None) -> None:
    """Make a movie of a run: .mp4 or .gif, as the file is called.

    Examples: `ecume movie runs/bowl` · `ecume movie runs/bowl -o bowl.gif`
    """
    from ecume.show.movies import movie as make

    typer.echo(f"wrote {make(directory, out)}")


def plot(
    directory: Annotated[
        Path | None, typer.Argument(metavar="[DIR]", help="The directory of a run.", show_default=False)
    ] = None,
    what: Annotated[
        list[str] | None,
        typer.Option(
            "--what",
            metavar="NAME",
            help="Which figure; may stand many times.",
            autocompletion=_figures,
            show_default=False,
        ),
    ] = None,
    out: Out = None,
    integrators: Annotated[
        bool, typer.Option("--integrators", help="Compare the integrators instead; needs no run.")
    ] = False,
) -> None:
    """Draw figures of a run: energies, clusters, paths, the force law. Left to itself, all of them.

    Examples: `ecume plot runs/bowl` · `ecume plot runs/bowl --what paths -o paths.pdf` · `ecume plot --integrators`
    """
    if (directory is None) != integrators:
        raise BadInput("wanted either the directory of a run or --integrators")
    from ecume.show import figures

    if directory is None:
        typer.echo(f"wrote {figures.integrator_comparison(out or Path('integrators.png'))}")
    elif what:
        _draw(directory, what, out)
    else:
        _draw_all(directory, out)


def _draw(directory: Path, names: list[str], out: Path | None) -> None:
    """The figures that were asked for."""
    from ecume.show.figures import plot as draw

    if out is not None and len(names) > 1:
        raise BadInput(f"{len(names)} figures do not fit into {out}; give --what once, or leave -o out")
    for name in names:
        typer.echo(f"wrote {draw(directory, name, out)}")


def _draw_all(directory: Path, out: Path | None) -> None:
    """Every figure that this run has something for."""
    from ecume.run.directory import existing
    from ecume.show.figures import FIGURES

    if out is not None:
        raise BadInput(f"say with --what which figure goes into {out}: {', '.join(FIGURES)}")
    existing(directory)
    for name in FIGURES:
        try:
            _draw(directory, [name], None)
        except BadInput as error:
            say(f"{name} left out: {error}")


def export(
    directory: RunFolder,
    to: Annotated[
        Format,
        typer.Option("--to", help="csv and xyz are text; vtk is for ParaView, npz for NumPy.", show_default=False),
    ],
    out: Out = None,
) -> None:
    """Write the frames of a run in another format.

    Examples: `ecume export runs/bowl --to csv` · `ecume export runs/bowl --to vtk -o bowl.vtkhdf`
    """
    from ecume.trajectories.exports import export as write

    typer.echo(f"wrote {write(directory, to.value, out or directory / f'frames{ENDINGS[to]}')}")


VERBS = (movie, plot, export)
