"""The verbs about scenes: new, check and cite; also the choice of the engine and of the compiler mode.

Scenes are checked in plain Python unless many particles have to be placed: loading compiled code takes longer than the
few loops of a check.
"""

from __future__ import annotations

import contextlib
import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from ecume.cli.options import argument, option
from ecume.cli.output import Json, echo, print_json, print_table
from ecume.errors import BadInput, Fault, SceneError, beside_ecume

if TYPE_CHECKING:
    from ecume.models.model import Engine
    from ecume.scenes.schema import Scene

EngineName = Annotated[
    str | None,
    option(
        "--engine",
        metavar="local|lammps",
        help="Integrate with ecume or with LAMMPS (extra `lammps`); default: local, or that of the run.",
    ),
]
Ranks = Annotated[
    int | None, option("--ranks", min=1, max=65536, metavar="N", help="Number of MPI ranks of LAMMPS; default: 1.")
]


@contextlib.contextmanager
def integrating(engine: str | None, ranks: int | None, directory: Path | None = None) -> Iterator[Engine | None]:
    """A context with the selected engine, or with that of the run in this directory. Raises BadInput if the engine is
    not installed.
    """
    from ecume.models.model import LAMMPS, LOCAL

    name = _engine_of(directory) if engine is None else engine
    if name not in (LOCAL, LAMMPS):
        raise BadInput(f"--engine: got {name!r}; expected one of {LOCAL}, {LAMMPS}")
    if name == LOCAL:
        if ranks is not None:
            raise BadInput("--ranks: expected it with --engine lammps only")
        yield None
        return
    with beside_ecume():
        from ecume_lammps.engine import lammps_engine
    with lammps_engine(ranks or 1) as selected:
        yield selected


def _engine_of(directory: Path | None) -> str:
    """The engine of a run; for a new run, that of ecume."""
    from ecume.models.model import LOCAL

    if directory is None:
        return LOCAL
    from ecume.run.directory import existing
    from ecume.run.verification import engine_of

    return engine_of(existing(directory))


FEW = 1000
"""The largest number of particles for which random placement in plain Python takes less time than loading compiled
code.
"""

own_process: list[bool] = []
"""Not empty if this process runs one command and ends."""


def without_compiler(scene: Scene) -> None:
    """Disable compilation if the check of a scene requires little computation and the process ends after it."""
    if own_process and "ecume._jit" not in sys.modules and is_small(scene):
        os.environ["NUMBA_DISABLE_JIT"] = "1"


def without_compiler_for(directory: Path) -> None:
    """Disable compilation for pictures and figures of a run that require little computation. Pictures of tanks require
    sums over all particles, and the surface around multipoles sums over all terms.
    """
    if own_process and "ecume._jit" not in sys.modules:
        from ecume.errors import EcumeError
        from ecume.trajectories.reader import open_trajectory

        with contextlib.suppress(EcumeError, OSError):  # reported by the code that draws
            scene = open_trajectory(directory).scene
            method = getattr(getattr(scene, "interaction", None), "method", "")
            if scene is not None and scene.model != "sph" and method != "multipole":
                without_compiler(scene)


def is_small(scene: Scene) -> bool:
    """Whether only few particles are placed one by one, and none beside curved solids in 3D; NumPy computes lattices of
    liquid.
    """
    from ecume.scenes.sph import SphScene

    if isinstance(scene, SphScene):
        curved = len(scene.tank.low) > 2 and any(solid.low is None for solid in (*scene.obstacles, *scene.bodies))
        placed = (region.particles or region.triangles or region.vertices for region in scene.fluid)
        return not curved and not any(placed)
    counts = [getattr(species, "number", None) or species.count or 1 for species in scene.particles]
    return sum(counts) + len(getattr(scene, "rows", ())) <= FEW


CHECK_COLUMNS = ("quantity", "value", "remark")

SceneFile = Annotated[Path, argument(metavar="SCENE", help="Scene file.")]
Overrides = Annotated[
    list[str] | None, option("--set", metavar="KEY=VALUE", help="Change a value of the scene; can be repeated.")
]

Laws = Annotated[
    list[str] | None,
    option("--laws", metavar="FILE.py[:NAME]", help="User laws: functions of a Python file; can be repeated."),
]
Actions = Annotated[
    list[str] | None,
    option(
        "--actions",
        metavar="FILE.py[:NAME]",
        help="User actions during the run: decorated functions of a Python file; can be repeated.",
    ),
]


def _names(incomplete: str) -> list[str]:
    """Templates whose names begin with the incomplete word, for the shell's completion."""
    from ecume.scenes.templates import sweep_templates, templates

    return [name for name in templates() | sweep_templates() if name.startswith(incomplete)]


def new(
    name: Annotated[
        str | None, argument(metavar="[NAME]", help="Name of a template; default: list all.", autocompletion=_names)
    ] = None,
    out: Annotated[Path | None, option("-o", "--out", metavar="FILE", help="Output file; default: NAME.toml.")] = None,
) -> None:
    """Write a template scene, or list the templates.

    Examples: `ecume new` · `ecume new cereal-bowl` · `ecume new two-spheres -o mine.toml`
    """
    from ecume.scenes.templates import by_model, copy_template, sweep_templates, templates

    if name is None:
        width = max(map(len, templates() | sweep_templates()))
        groups = {**by_model(), "Sweeps": sweep_templates()}
        echo("\n\n".join("\n".join([f"{group}:", *_listed(listed, width)]) for group, listed in groups.items()))
        return
    for path in copy_template(name, out or Path(f"{name}.toml")):
        echo(f"wrote {path}")


def _listed(names: dict[str, str], width: int) -> Iterator[str]:
    """The lines of a list of templates with their titles."""
    return (f"  {name:<{width}}  {says}" for name, says in names.items())


def check(scene: SceneFile, overrides: Overrides = None, laws: Laws = None, json: Json = False) -> None:
    """Check a scene and print derived quantities.

    Prints all faults of the scene at once, or its lengths, charges, time step, memory, disk space and run time.

    Examples: `ecume check bowl.toml` · `ecume check bowl.toml --set "dish.radius=4 cm" --set particles[0].count=60`
    """
    from ecume.scenes.valid_part import load_and_examine

    changes = overrides or []
    with questioned(scene, changes):
        asked = load_and_examine(scene, changes, examine)
    from ecume.run.selection import names_quantities

    if not laws and not names_quantities(asked):
        without_compiler(asked)
    from ecume.models import MODELS
    from ecume.run.user_code import laws_from, named
    from ecume.simulation import extended

    own = laws_from(laws or [])
    with questioned(scene, changes), placed(scene, changes):
        model = MODELS[asked.model]
        if own:
            model = extended(model, asked, own)
            model.start(asked, model.parameters(asked))
        rows = list(model.summary(asked))
        _require_known(asked)
    listed = [law.law for law in asked.user_laws]
    if own or listed:
        remark = "added to those of the scene" if own else "not checked: give their file with --laws"
        rows.append(("user laws", ", ".join(map(named, own)) or ", ".join(listed), remark))
    rows += odd_values(scene, changes, asked)
    if json:
        print_json([dict(zip(CHECK_COLUMNS, row, strict=True)) for row in rows])
        return
    print_table(CHECK_COLUMNS, rows)


@contextmanager
def questioned(file: Path, changes: Sequence[str]) -> Iterator[None]:
    """A context that adds the implausible values of a scene file to its faults, since they often cause these."""
    try:
        yield
    except SceneError as error:
        known = [fault.path for fault in error.faults]
        odd = [(key, text) for key, text in questions(file, changes) if not any(path.startswith(key) for path in known)]
        raise SceneError([*error.faults, *(Fault(key, text) for key, text in odd)], error.source) from None


def questions(file: Path, changes: Sequence[str]) -> list[tuple[str, str]]:
    """The keys and remarks of implausible values of a scene file with changes. Empty for a file that cannot be read."""
    from ecume.scenes.load import parsed, source_of
    from ecume.scenes.overrides import overridden
    from ecume.scenes.plausible import remarks

    try:
        raw = parsed(source_of(file))
    except BadInput:
        return []
    overridden(raw, changes)
    return [(key, f"got {value}, {text}") for key, value, text in remarks(raw)]


def odd_values(file: Path, changes: Sequence[str], scene: Scene) -> list[tuple[str, str, str]]:
    """A row for each implausible value of a scene file, for each drawing without a unit, and for velocities without
    one.
    """
    from ecume.scenes.load import parsed, source_of
    from ecume.scenes.overrides import overridden
    from ecume.scenes.plausible import remarks
    from ecume.scenes.sph.sources import drawn_sizes

    raw = parsed(source_of(file))
    overridden(raw, changes)
    return [*remarks(raw), *drawn_sizes(raw, scene), *velocities_without_a_unit(file, changes)]


def velocities_without_a_unit(file: Path, changes: Sequence[str]) -> list[tuple[str, str, str]]:
    """A row if a valid scene starts from a file whose velocities are ignored."""
    from ecume.scenes.load import parsed, source_of
    from ecume.scenes.overrides import overridden
    from ecume.scenes.starts import ignored_velocities

    source = source_of(file)
    raw = parsed(source)
    overridden(raw, changes)
    return ignored_velocities(raw, source.folder)


def examine(scene: Scene) -> None:
    """Raise SceneError for the faults that the model finds."""
    from ecume.models import MODELS

    MODELS[scene.model].summary(scene)
    _require_known(scene)


def _require_known(scene: Scene) -> None:
    """Raise SceneError for output quantities that the frames of a scene do not have."""
    from ecume.run.selection import names_quantities, require_known

    if names_quantities(scene):
        from ecume.simulation import simulate

        require_known(scene, next(simulate(scene)))


@contextmanager
def placed(file: Path, changes: Sequence[str]) -> Iterator[None]:
    """A context that adds the lines of the scene's file to faults that a model finds."""
    from ecume.scenes.load import located

    try:
        yield
    except SceneError as error:
        raise located(error, file, changes) from None


def cite(scene: SceneFile, overrides: Overrides = None) -> None:
    """Print references for the laws that a scene uses, as BibTeX.

    Example: `ecume cite bowl.toml > bowl.bib`
    """
    from ecume.citing import bibtex, papers_of
    from ecume.scenes.load import load_scene

    echo(bibtex(papers_of(load_scene(scene, overrides or []))), nl=False)


VERBS = (new, check, cite)
