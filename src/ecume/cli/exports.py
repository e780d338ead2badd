"""The verb export."""

from __future__ import annotations

import sys
import tempfile
from enum import StrEnum
from pathlib import Path
from typing import Annotated

from ecume.cli.options import argument, option
from ecume.cli.output import RESULTS, Out, wrote
from ecume.cli.runs import HERE, Quiet
from ecume.cli.scenes import Overrides, placed, without_compiler
from ecume.errors import BadInput, beside_ecume

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
    option("--author", metavar="NAME", help="Author of the run, with an ORCID if any, for ro-crate. Can be repeated."),
]
License = Annotated[
    str | None, option("--license", metavar="ID", help="License of the run for ro-crate, such as CC-BY-4.0.")
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


RunOrScene = Annotated[
    Path,
    argument(metavar="DIR", help="Directory of a run, or a scene file for lammps; default: the current directory."),
]


def export(
    directory: RunOrScene = HERE,
    *,
    to: Annotated[
        Format,
        option(
            "--to",
            help="csv, xyz: text; numbers: CSV of energies, gauges ...; samples: numbers sampled between frames; "
            "vtk: ParaView (pvd: before 5.12); npz: NumPy; "
            "heights, heights-vtk: the surface around floats on a grid, for NumPy (.npz, or -o FILE.npy) and ParaView; "
            "ro-crate: metadata of the run in its directory; lammps: a scene as a folder with an input script.",
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


VERBS = (export,)
