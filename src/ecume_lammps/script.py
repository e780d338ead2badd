"""The input script of a deck, section by section, and its first state as a data file."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from ecume_lammps.numbers import ROLLING, DeckNumbers
from ecume_lammps.pair_tables import ACCURACY, PairTable, lookup_of
from ecume_lammps.walls import Formula, box_of, flow_of, meniscus_of, region_of

DATA, TABLES = "floats.data", "pairs.table"

FAR = "zero"
"""The pair style of floats without any force."""

SEEDS, STRIDE = 899_999_813, 40_503
"""The number of seeds, and the increment from step to step. LAMMPS accepts seeds up to 900,000,000. The number is
prime, so that a seed recurs only after as many steps.
"""


def script_text(deck: DeckNumbers, tables: list[PairTable]) -> str:
    """The input script; `tables` are the tables in the file beside it."""
    return _joined(_head(deck), _style(deck), _lengths(deck), *_system(deck, tables), _output(deck))


def setup_text(deck: DeckNumbers, tables: list[PairTable]) -> str:
    """The commands before the first time step."""
    return _joined(_style(deck), *_system(deck, tables), iter([f"timestep        {deck.time_step!r}"]))


def external_text(deck: DeckNumbers) -> str:
    """The commands before the first time step if ecume computes all forces except contacts; all
    floats have one type.
    """
    parts = _style(deck), _atoms(deck, {}), _pairs(deck, [], FAR), _walls(deck), _external()
    return _joined(*parts, iter([f"timestep        {deck.time_step!r}"]))


def _external() -> Iterator[str]:
    yield "fix             ecume all external pf/callback 1 1"
    yield "fix             move all nve"
    yield "fix             flat all enforce2d"


def _joined(*sections: Iterator[str]) -> str:
    return "\n\n".join(text for text in ("\n".join(section) for section in sections) if text) + "\n"


def _system(deck: DeckNumbers, tables: list[PairTable]) -> Iterator[Iterator[str]]:
    formulas = {name: found for name, found in (("meniscus", meniscus_of(deck)), ("flow", flow_of(deck))) if found}
    yield _atoms(deck, formulas)
    yield _pairs(deck, tables)
    yield _walls(deck)
    yield from (_formula(name, formula) for name, formula in formulas.items())
    yield _motion(deck)


def _head(deck: DeckNumbers) -> Iterator[str]:
    yield f"# {in_a_comment(deck.scene.title or 'Floats')}, written by ecume: see README.md. Run it in this folder:"
    yield "#   lmp -in in.lammps    or    mpiexec -n 8 lmp -in in.lammps"


def in_a_comment(title: str) -> str:
    """A title for a comment, in which LAMMPS would interpret quotes, `$` and `&`.

    >>> in_a_comment('bowl of "milk" & ${x}')
    "bowl of 'milk' + {x}"
    """
    return title.translate({ord('"'): "'", ord("$"): None, ord("&"): "+", ord("\\"): "/"})


def _style(deck: DeckNumbers) -> Iterator[str]:
    bounds = "p p" if deck.scene.cell is not None else "m m"
    yield "units           si"
    yield "dimension       2"
    yield f"boundary        {bounds} p"
    yield "atom_style      sphere"
    yield "newton          on"
    yield "comm_modify     vel yes"


def _lengths(deck: DeckNumbers) -> Iterator[str]:
    yield "# Time steps, time steps between frames, and the time step (s): -var steps N changes the first, and so on."
    yield f"variable        steps index {deck.steps}"
    yield f"variable        frame index {deck.steps_per_frame}"
    yield f"variable        step index {deck.time_step!r}"


def _atoms(deck: DeckNumbers, formulas: dict[str, Formula]) -> Iterator[str]:
    names = [name for formula in formulas.values() for name in formula.properties]
    if names:
        yield f"fix             numbers all property/atom {' '.join(names)}"
    yield f"read_data       {DATA}"
    for name, value in _named(formulas):
        for kind, number in enumerate(value, 1):
            yield f"set             type {kind} {name} {number!r}"


def _named(formulas: dict[str, Formula]) -> Iterator[tuple[str, list[float]]]:
    """The names of all properties of atoms, each with its value for each kind."""
    for formula in formulas.values():
        yield from zip(formula.properties, formula.values, strict=True)


def contact_model(deck: DeckNumbers, restitution: float, friction: float) -> str:
    """The arguments of `pair_style granular` and `fix wall/gran/region granular` for a contact."""
    assert deck.contacts is not None  # noqa: S101  # asked with contacts only
    stiffness = deck.contacts.stiffness
    sliding = (
        f"linear_history {ROLLING * stiffness!r} {ROLLING!r} {friction!r}"
        if friction > 0.0
        else "linear_nohistory 0.0 0.0"
    )
    normal = f"hooke {stiffness!r} {restitution!r}"
    return f"{normal} tangential {sliding} damping coeff_restitution limit_damping"


def _pairs(deck: DeckNumbers, tables: list[PairTable], far: str = "") -> Iterator[str]:
    """The commands for pair forces. `far` is the pair style for forces that another fix computes; it sets the range of
    ghosts.
    """
    cutoff = deck.parameters.cutoff
    styles = [f"table {lookup_of(deck.parameters)}"] if tables else []
    styles += [f"{far} {cutoff!r}"] if far else []
    styles += ["granular"] if deck.contacts is not None else []
    styles = styles or [f"{FAR} {cutoff!r}"]
    if tables:
        yield f"# Tables of our pair law, to {ACCURACY:g} of each force."
    yield f"pair_style      hybrid/overlay {' '.join(styles)}"
    for table in tables:
        i, j = (kind + 1 for kind in table.kinds)
        yield f"pair_coeff      {i} {j} table {TABLES} {table.name} {cutoff!r}"
    if deck.contacts is not None:
        model = contact_model(deck, deck.contacts.among, deck.contacts.friction[0])
        yield f"pair_coeff      * * granular {model}"
    if far or styles == [f"{FAR} {cutoff!r}"]:
        yield f"pair_coeff      * * {FAR}"
    yield f"neighbor        {deck.parameters.skin!r} bin"
    yield "neigh_modify    every 1 delay 0 check yes"


def _walls(deck: DeckNumbers) -> Iterator[str]:
    if deck.scene.dish is None or deck.contacts is None:
        return
    yield region_of(deck)
    model = contact_model(deck, deck.contacts.at_walls, deck.contacts.friction[1])
    yield f"fix             wall all wall/gran/region granular {model} region dish"


def _formula(name: str, formula: Formula) -> Iterator[str]:
    yield from formula.lines
    yield f"fix             {name} all addforce v_{name}_x v_{name}_y 0.0"


def _motion(deck: DeckNumbers) -> Iterator[str]:
    if deck.parameters.scheme.inertia:
        yield from _inertial(deck)
    else:
        yield from _overdamped(deck)
    yield "fix             flat all enforce2d"


def _inertial(deck: DeckNumbers) -> Iterator[str]:
    """The commands for velocity Verlet with drag as a force."""
    friction = _friction(deck)
    if any(friction):
        yield f"fix             drag all viscous {_scaled(friction)}"
    turning = deck.turning.friction if deck.turning is not None else []
    if any(turning):
        yield f"fix             spin_drag all viscous/sphere {_scaled(turning)}"
    yield f"fix             move all {'nve' if deck.turning is None else 'nve/sphere'}"


def _overdamped(deck: DeckNumbers) -> Iterator[str]:
    """The commands for overdamped motion: velocities from forces and drag, with noise if the scene has it."""
    noise, seed = "gaussian" if deck.parameters.drift.thermal > 0.0 else "none", _seed(deck)
    for kind, friction in enumerate(_friction(deck), 1):
        group = "all"
        if len(deck.kinds) > 1:
            group = f"kind_{kind}"
            yield f"group           {group} type {kind}"
        model = f"brownian {deck.scene.liquid.temperature!r} {seed + kind} gamma_t {friction!r} rng {noise}"
        yield f"fix             move_{kind} {group} {model}"


def _seed(deck: DeckNumbers) -> int:
    """The seed of the random numbers for this state; each step of a run has another one."""
    return (deck.scene.seed + STRIDE * int(deck.state.step[0])) % SEEDS + 1


def _friction(deck: DeckNumbers) -> list[float]:
    """The friction of each kind (N s/m); zero without drag."""
    floats = deck.parameters.floats
    found: list[float] = (floats.mass / floats.relaxation_time)[deck.first].tolist()
    return found


def _scaled(values: list[float]) -> str:
    """The arguments of a viscous fix: the first value, and the ratios of the others to it."""
    scales = [f"scale {kind} {value / values[0]!r}" for kind, value in enumerate(values[1:], 2)]
    return " ".join([repr(values[0]), *scales])


def _output(deck: DeckNumbers) -> Iterator[str]:
    yield "timestep        ${step}"
    yield "thermo_style    custom step time pe ke"
    yield "thermo_modify   lost error"
    yield "thermo          ${frame}"
    yield "dump            frames all custom ${frame} frames.dump id type x y vx vy fx fy radius"
    yield "dump_modify     frames sort id format float %.17g time yes"
    yield "run             ${steps}"


def density_of(deck: DeckNumbers) -> list[float]:
    """The densities (kg/m^3) with which spheres of these radii have the masses of the floats."""
    floats = deck.parameters.floats
    found: list[float] = (floats.mass / (4.0 / 3.0 * math.pi * floats.radius**3)).tolist()
    return found


def thickness_of(deck: DeckNumbers) -> float:
    """Half of the thickness of the box (m). It has no effect in 2D, but LAMMPS refuses values far below the cutoff."""
    return max(float(deck.parameters.floats.radius.max()), 0.1 * deck.parameters.cutoff)


def data_text(deck: DeckNumbers) -> str:
    """The data file: box, atoms of the style `sphere`, velocities."""
    x_low, x_high, y_low, y_high = box_of(deck)
    half = thickness_of(deck)
    state = deck.state
    spin = state.turning[:, 1] if len(state.turning) and state.turning.shape[1] else np.zeros(len(state.position))
    numbers = range(1, len(state.position) + 1)
    atoms = zip(numbers, (deck.kind + 1).tolist(), (2.0 * deck.parameters.floats.radius).tolist(), density_of(deck),
                *state.position.T.tolist(), strict=True)  # fmt: skip
    speeds = zip(numbers, *state.velocity.T.tolist(), spin.tolist(), strict=True)
    return "\n".join(
        [
            f"{in_a_comment(deck.scene.title or 'Floats')}, written by ecume; SI units",
            "",
            f"{len(state.position)} atoms",
            f"{len(deck.kinds)} atom types",
            "",
            f"{x_low!r} {x_high!r} xlo xhi",
            f"{y_low!r} {y_high!r} ylo yhi",
            f"{-half!r} {half!r} zlo zhi",
            "",
            "Atoms  # sphere",
            "",
            *(f"{n} {kind} {diameter!r} {density!r} {x!r} {y!r} 0.0" for n, kind, diameter, density, x, y in atoms),
            "",
            "Velocities",
            "",
            *(f"{n} {vx!r} {vy!r} 0.0 0.0 0.0 {turn!r}" for n, vx, vy, turn in speeds),
            "",
        ]
    )
