"""The deck of a scene: a folder with input for any LAMMPS, and a README."""

from __future__ import annotations

import importlib.metadata
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from ecume._plain_files import content_of
from ecume.errors import BadInput
from ecume.models.floating.contacts.springs import SHALLOW
from ecume.models.floating.dishes import NO_WALL_LAW
from ecume.models.floating.forces.pair_forces import row_of
from ecume.trajectories.records import storing, write_whole
from ecume.units import with_prefix
from ecume_lammps import tanks
from ecume_lammps.expressible import require_expressible
from ecume_lammps.numbers import DRAG_STEP, DeckNumbers, numbers_of
from ecume_lammps.pair_tables import ACCURACY, OVERLAP, PairTable, pair_tables, text_of
from ecume_lammps.script import DATA, TABLES, data_text, script_text
from ecume_lammps.tanks import TANKS, tank_of

if TYPE_CHECKING:
    from ecume.scenes.floating import FloatingScene
    from ecume.scenes.schema import Scene
    from ecume.scenes.sph import SphScene


class Statement(NamedTuple):
    """One line of the README, and the decks to which it applies."""

    applies: Callable[[DeckNumbers], bool]
    text: Callable[[DeckNumbers], str]


def _always(deck: DeckNumbers) -> bool:
    return True


def _has_contacts(deck: DeckNumbers) -> bool:
    return deck.contacts is not None


def _has_drag(deck: DeckNumbers) -> bool:
    return deck.parameters.scheme.inertia and bool((deck.parameters.floats.relaxation_time < float("inf")).all())


def _is_stiffened(deck: DeckNumbers) -> bool:
    return _has_contacts(deck) and deck.scene.contacts.law == "impulse"


def _meniscus_text(deck: DeckNumbers) -> str:
    law = deck.scene.dish.law if deck.scene.dish is not None else "none"
    return f"The meniscus of the wall (`{law}`): a formula in `fix addforce`, equal to the law of ecume to 1e-9."


def _same(text: str) -> Callable[[DeckNumbers], str]:
    """A statement that contains no numbers of the deck."""
    return lambda deck: text


EXACT = (
    Statement(_always, _same("Radii, masses, initial positions and velocities: the same numbers.")),
    Statement(lambda deck: deck.parameters.wall_law != NO_WALL_LAW, _meniscus_text),
    Statement(
        lambda deck: deck.parameters.drift.flows, _same("The drag of the flowing surface: a formula in `fix addforce`.")
    ),
    Statement(
        lambda deck: deck.scene.contacts.law == "spring-dashpot",
        _same("Contacts: the springs and dashpots of the scene, which end when their force does (`limit_damping`)."),
    ),
    Statement(
        lambda deck: any(one.disc is not None for one in deck.scene.given),
        _same("Discs are atoms with the radius and the mass of the disc; without friction nothing turns."),
    ),
    Statement(_always, _same("Two dimensions: `fix enforce2d`.")),
)
"""Statements on what LAMMPS computes in the same way as ecume."""


def _contact_text(deck: DeckNumbers) -> str:
    assert deck.contacts is not None  # noqa: S101  # only asked with contacts
    at_wall = f" (at the wall {deck.scene.dish.restitution:g})" if deck.scene.dish is not None else ""
    return (
        f"Rigid contacts with restitution {deck.scene.contacts.restitution:g}{at_wall} are springs of "
        f"{deck.contacts.stiffness:.4g} N/m with dashpots. The strongest attraction in a raft causes overlaps of "
        f"{SHALLOW:g} of a radius. A single collision has the same restitution: `granular` gets "
        f"{deck.contacts.among:.6g}{f' (wall {deck.contacts.at_walls:.6g})' if at_wall else ''}, the restitution of a "
        "dashpot that may pull, and `limit_damping` ends contacts when their force does, with the restitution of the "
        "scene up to the error of the time step (0.19 in place of 0.2). Simultaneous collisions differ: springs act "
        "one by one, impulses of ecume are solved together."
    )


def _soft_text(deck: DeckNumbers) -> str:
    assert deck.contacts is not None  # noqa: S101  # only asked with contacts
    return (
        f"Rigid contacts are springs of {deck.contacts.stiffness:.4g} N/m without dashpots. The strongest attraction "
        f"in a raft causes overlaps of {SHALLOW:g} of a radius. Without inertia nothing rebounds."
    )


def _step_text(deck: DeckNumbers) -> str:
    return (
        f"Time: {deck.steps} steps of {with_prefix(deck.time_step, 's', 4)}, at most a twentieth of the duration of a "
        "contact and of the time scale of the pair law. LAMMPS integrates with velocity Verlet, whatever "
        "`integration.integrator` and `integration.time_step` of the scene are."
    )


def _overdamped_text(deck: DeckNumbers) -> str:
    noise = " and noise" if deck.parameters.drift.thermal > 0.0 else ""
    return (
        f"Time: {deck.steps} steps of {with_prefix(deck.time_step, 's', 4)}. `fix brownian` computes velocities from "
        f"forces{noise}, as the integrator `overdamped` does. Random numbers differ, and LAMMPS's Boltzmann constant "
        "is larger by 1e-6."
    )


def _table_text(deck: DeckNumbers) -> str:
    return (
        f"Attraction: tables of the pair law, one for each pair of kinds, with an error below {ACCURACY:g} of each "
        f"force (cutoff {with_prefix(deck.parameters.cutoff, 'm', 4)}, as in ecume with the scene's "
        f"`interaction.accuracy`). They begin at an overlap of {OVERLAP:g} of the sum of the radii, where LAMMPS stops "
        "with `Pair distance < table inner cutoff`."
    )


def _drag_text(deck: DeckNumbers) -> str:
    return (
        f"Drag: an explicit force (`fix viscous`) with steps of at most {DRAG_STEP:g} of the shortest relaxation time; "
        "ecume solves drag exactly."
    )


APPROXIMATE = (
    Statement(lambda deck: row_of(deck.parameters).has_force, _table_text),
    Statement(lambda deck: _is_stiffened(deck) and deck.parameters.scheme.inertia, _contact_text),
    Statement(lambda deck: _is_stiffened(deck) and not deck.parameters.scheme.inertia, _soft_text),
    Statement(
        lambda deck: deck.turning is not None,
        _same(
            "Friction: Coulomb's coefficients are the same. A sticking contact is a tangential spring of 2/7 of the "
            "normal stiffness (`linear_history`), whose period is that of the normal spring."
        ),
    ),
    Statement(_has_drag, _drag_text),
    Statement(lambda deck: deck.parameters.scheme.inertia, _step_text),
    Statement(lambda deck: not deck.parameters.scheme.inertia, _overdamped_text),
)
"""Statements on what LAMMPS computes in another way."""


def readme_text(deck: DeckNumbers, tables: list[PairTable]) -> str:
    """The README."""
    return "\n".join(_lines(deck, tables)) + "\n"


def _lines(deck: DeckNumbers, tables: list[PairTable]) -> Iterator[str]:
    yield f"# {deck.scene.title or 'Floats'}: a deck for LAMMPS"
    yield ""
    yield f"Written by ecume {importlib.metadata.version('ecume')}. SI units. Packages of LAMMPS: {_packages(deck)}."
    yield "Tested with the release of 22 July 2025."
    yield ""
    yield "    lmp -in in.lammps"
    yield "    mpiexec -n 8 lmp -in in.lammps"
    yield ""
    yield "| file | contents |"
    yield "|---|---|"
    yield "| `in.lammps` | the input script; `-var steps N`, `-var frame N` and `-var step S` change its steps |"
    yield "| `floats.data` | radii, masses, positions and velocities |"
    if tables:
        yield f"| `pairs.table` | the pair law, {len(tables)} {'table' if len(tables) == 1 else 'tables'} |"
    yield "| `frames.dump` | written by LAMMPS: positions, velocities and forces |"
    yield ""
    yield "## Kinds of floats"
    yield ""
    yield "| type | radius (m) | mass (kg) | capillary charge (m) | floats | species |"
    yield "|---|---|---|---|---|---|"
    yield from _kinds(deck)
    for title, statements in (("Exact", EXACT), ("Approximated", APPROXIMATE)):
        yield ""
        yield f"## {title}"
        yield ""
        yield from (f"- {statement.text(deck)}" for statement in statements if statement.applies(deck))


def _kinds(deck: DeckNumbers) -> Iterator[str]:
    floats, names = deck.parameters.floats, [kind.name for kind in deck.scene.kinds]
    for number, first in enumerate(deck.first.tolist()):
        species = sorted({names[of] for of in floats.species[deck.kind == number].tolist()})
        count = int((deck.kind == number).sum())
        yield (
            f"| {number + 1} | {floats.radius[first]:.9g} | {floats.mass[first]:.9g} | {floats.charge[first]:.9g} | "
            f"{count} | {', '.join(species)} |"
        )


def _packages(deck: DeckNumbers) -> str:
    needed = ["GRANULAR"] if deck.contacts is not None else []
    needed += ["BROWNIAN"] if not deck.parameters.scheme.inertia else []
    needed += ["EXTRA-FIX"] if deck.turning is not None else []
    return ", ".join(needed) or "none"


SCRIPT, README = "in.lammps", "README.md"


def floating_deck(scene: FloatingScene) -> dict[str, str]:
    """The files of the deck of a floating scene, by name. Raises SceneError for features that LAMMPS cannot express."""
    require_expressible(scene)
    deck = numbers_of(scene)
    tables = list(pair_tables(deck))
    files = {SCRIPT: script_text(deck, tables), DATA: data_text(deck), README: readme_text(deck, tables)}
    return files | ({TABLES: "".join(map(text_of, tables))} if tables else {})


def tank_deck(scene: SphScene) -> dict[str, str]:
    """The files of the deck of a tank, by name. Raises SceneError for features that LAMMPS cannot express."""
    require_expressible(scene, TANKS)
    tank = tank_of(scene)
    texts = tanks.script_text(tank), tanks.data_text(tank), tanks.readme_text(tank)
    return dict(zip((SCRIPT, tanks.DATA, README), texts, strict=True))


DECKS: Mapping[str, Callable[[Any], dict[str, str]]] = {"floating": floating_deck, "sph": tank_deck}
"""The decks of each model."""


def _require_own(folder: Path, files: Mapping[str, str]) -> None:
    """Raise BadInput if files of a deck would replace other files: a folder counts as a deck only if it contains a
    script.
    """
    there = [name for name in files if (folder / name).exists()]
    script = folder / SCRIPT
    if there and not (script.is_file() and b"written by ecume" in content_of(script, MOST_BYTES)[:MOST_TITLE]):
        raise BadInput(f"{folder / there[0]}: exists, and no deck of ecume is there; choose another folder with -o")


MOST_BYTES, MOST_TITLE = 2**26, 2000
"""The largest size of a script in bytes, and of its first lines in characters."""


def write_deck(scene: Scene, folder: Path) -> Path:
    """Write the deck of a scene into a folder. Raises BadInput for models without decks."""
    if scene.model not in DECKS:
        known = ", ".join(DECKS)
        raise BadInput(f"--to lammps: got a scene of the model {scene.model}; expected one of: {known}")
    files = DECKS[scene.model](scene)
    _require_own(folder, files)
    with storing(folder):
        folder.mkdir(exist_ok=True)
    for name, text in files.items():
        write_whole(folder / name, text, settled=False)
    return folder
