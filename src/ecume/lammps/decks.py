"""A deck: a folder with which any LAMMPS simulates a scene."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ecume.errors import BadInput
from ecume.lammps import tank_script
from ecume.lammps.data_file import data_text
from ecume.lammps.expressible import require_expressible
from ecume.lammps.numbers import numbers_of
from ecume.lammps.pair_tables import pair_tables, text_of
from ecume.lammps.readme import readme_text
from ecume.lammps.script import DATA, TABLES, script_text
from ecume.lammps.tanks import TANKS, tank_of
from ecume.trajectories.durable_files import storing, write_whole

if TYPE_CHECKING:
    from ecume.scenes.floating import FloatingScene
    from ecume.scenes.schema import Scene
    from ecume.scenes.sph import SphScene

SCRIPT, README = "in.lammps", "README.md"


def floating_deck(scene: FloatingScene) -> dict[str, str]:
    """The files of the deck of a scene of floats, by name. Raises SceneError for what LAMMPS cannot express."""
    require_expressible(scene)
    deck = numbers_of(scene)
    tables = list(pair_tables(deck))
    files = {SCRIPT: script_text(deck, tables), DATA: data_text(deck), README: readme_text(deck, tables)}
    return files | ({TABLES: "".join(map(text_of, tables))} if tables else {})


def tank_deck(scene: SphScene) -> dict[str, str]:
    """The files of the deck of a tank, by name. Raises SceneError for what LAMMPS cannot express."""
    require_expressible(scene, TANKS)
    tank = tank_of(scene)
    texts = tank_script.script_text(tank), tank_script.data_text(tank), tank_script.readme_text(tank)
    return dict(zip((SCRIPT, tank_script.DATA, README), texts, strict=True))


DECKS: Mapping[str, Callable[[Any], dict[str, str]]] = {"floating": floating_deck, "sph": tank_deck}
"""The decks of each model."""


def write_deck(scene: Scene, folder: Path) -> Path:
    """Write the deck of a scene into a folder. Raises BadInput for models without decks."""
    if scene.model not in DECKS:
        known = ", ".join(DECKS)
        raise BadInput(f"--to lammps: got a scene of the model {scene.model}; expected one of: {known}")
    files = DECKS[scene.model](scene)
    with storing(folder):
        folder.mkdir(exist_ok=True)
    for name, text in files.items():
        write_whole(folder / name, text, settled=False)
    return folder
