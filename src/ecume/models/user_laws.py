"""User-defined laws: binding functions to the species and constants of a scene, and compiling them.

A pair law is a function (distance, parameters) -> force (N); an external law is a function (position, velocity, time,
parameters) -> acceleration (m/s^2); a flow is a function (position, time, constants) -> velocity of the liquid (m/s).
Each model defines the particles on which a law acts, and the fields of `parameters`.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Sequence
from types import FunctionType
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from ecume._dependencies import exact_digest
from ecume._jit import compiled, compiled_once, plainly
from ecume.errors import BadInput, Fault, SceneError, nearest

if TYPE_CHECKING:
    from ecume.scenes.schema import Scene

PAIR, FLOW, EXTERNAL = 2, 3, 4
"""The number of arguments of a law, which determines its kind."""
KINDS = {
    PAIR: "pair laws (distance, parameters)",
    FLOW: "flows (position, time, constants)",
    EXTERNAL: "external laws (position, velocity, time, parameters)",
}
MOST_LAWS = 60
"""The largest number of laws, which are bits of an integer."""

Function = Callable[..., Any]


Law = TypeVar("Law", bound=Callable[..., Any])
KEY = 32
"""The number of letters of a digest."""


def compiled_for_laws(function: Law, compiler: Callable[..., Any] = compiled) -> Law:
    """Compile a user function, or a function around it, by a decorator of `_jit`. It is cached on disk unless it refers
    to objects that cannot be described; its name contains a digest of its content, since code is linked by names.
    """
    if not isinstance(function, FunctionType) or (key := exact_digest(function)) is None:
        return compiled_once(function)
    own = FunctionType(
        function.__code__, function.__globals__, function.__name__, function.__defaults__, function.__closure__
    )
    own.__kwdefaults__, own.__module__ = function.__kwdefaults__, function.__module__
    own.__qualname__ = f"{function.__qualname__}_{key}"
    made: Any = compiler(own)
    kept: Law = made
    return kept


def key_of(function: Any) -> str | None:
    """The digest in the name of a function that is compiled for laws; None without one."""
    key = getattr(plainly(function), "__qualname__", "").rpartition("_")[2]
    return key if len(key) == KEY else None


class BoundLaw(NamedTuple):
    """A user function with the species and the constants of one use."""

    function: Function
    species: tuple[int, ...]
    """of a pair, or one; empty for all"""
    constants: tuple[float, ...]

    @property
    def name(self) -> str:
        """The name of the function."""
        return named(self.function)

    @property
    def arguments(self) -> int:
        """The number of arguments."""
        return arguments_of(self.function)


def named(function: object) -> str:
    """The name of a function."""
    return str(getattr(function, "__name__", None) or repr(function))


def arguments_of(function: Function) -> int:
    """The number of arguments of a function. Raises BadInput for anything else."""
    try:
        return len(inspect.signature(getattr(function, "py_func", function)).parameters)
    except TypeError:
        raise BadInput(f"extra_laws: got {function!r}; expected a function (distance, parameters) -> force") from None


def bind(scene: Scene, functions: Sequence[Function]) -> list[BoundLaw]:
    """The laws of a scene: its `user_laws`, followed by the given functions that it does not list, which act on all
    species.

    Raises SceneError for names that are not given, and for unknown species.
    """
    given, names, faults = {named(each): each for each in functions}, species_names(scene), []
    bound = []
    for k, spec in enumerate(scene.user_laws):
        if spec.law not in given:
            cure = f"give its file: --laws FILE.py:{spec.law}, or extra_laws=[{spec.law}]"
            faults.append(Fault(f"user_laws[{k}].law", f"got {spec.law!r}, a function that is not given; {cure}"))
            continue
        arguments = arguments_of(given[spec.law])
        required = {PAIR: 2, EXTERNAL: 1}.get(arguments, 0)
        if spec.species and len(spec.species) != required:
            what = f"got {len(spec.species)} names; expected {required} for a law of {arguments} arguments"
            faults.append(Fault(f"user_laws[{k}].species", what))
        unknown = [name for name in spec.species if name not in names]
        faults += [Fault(f"user_laws[{k}].species", f"got {name!r}; {nearest(name, names)}") for name in unknown]
        if not unknown:
            species = tuple(names.index(name) for name in spec.species)
            bound.append(BoundLaw(given[spec.law], species, spec.constants))
    if faults:
        raise SceneError(faults)
    listed = {spec.law for spec in scene.user_laws}
    bound += [BoundLaw(each, (), ()) for name, each in given.items() if name not in listed]
    if len(bound) > MOST_LAWS:
        raise BadInput(f"extra_laws: got {len(bound)} laws; expected at most {MOST_LAWS}")
    return bound


def species_names(scene: Scene) -> list[str]:
    """The species of a scene; the regions of liquid in a tank are `fluid-1`, `fluid-2`, ..."""
    regions = getattr(scene, "fluid", ())
    return [kind.name for kind in scene.kinds] or [f"fluid-{number + 1}" for number in range(len(regions))]


def require_kinds(model: str, laws: Sequence[BoundLaw], kinds: Sequence[int]) -> None:
    """Raise BadInput for laws that a model cannot use."""
    for law in laws:
        if law.arguments not in kinds:
            required = " or ".join(KINDS[kind] for kind in kinds)
            raise BadInput(
                f"extra_laws: {law.name}: got {law.arguments} arguments; the model {model} expects {required}"
            )


def masks_of(laws: Sequence[BoundLaw], count: int) -> NDArray[np.int64]:
    """(S, S) of pair laws: bit k of entry (a, b) is set where law k acts between the species a and b."""
    mask = np.zeros((count, count), np.int64)
    for bit, law in enumerate(laws):
        if law.species:
            one, other = law.species
            mask[one, other] |= 1 << bit
            mask[other, one] |= (1 << bit) if one != other else 0
        else:
            mask |= 1 << bit
    return mask


def flags_of(laws: Sequence[BoundLaw], count: int) -> NDArray[np.int64]:
    """(S,) of external laws: bit k of entry a is set where law k acts on the species a."""
    flags = np.zeros(count, np.int64)
    for bit, law in enumerate(laws):
        flags[list(law.species) or slice(None)] |= 1 << bit
    return flags


def sum_of_pair_laws(laws: Sequence[BoundLaw], joined: Function) -> Function:
    """Return a compiled function (distance, own, mask) -> the force of all laws in the mask (N).

    `joined(own, constants)` makes the `parameters` of a law.
    """
    total = _no_force
    for bit, law in enumerate(laws):
        total = _added(compiled_for_laws(law.function), law.constants, 1 << bit, (total, joined))
    return total


def _added(law: Function, constants: tuple[float, ...], flag: int, others: tuple[Function, Function]) -> Function:
    rest, joined = others

    @compiled_for_laws
    def both(distance: float, own: Any, mask: int) -> float:
        force: float = rest(distance, own, mask)
        if mask & flag:
            force += law(distance, joined(own, constants))
        return force

    return both


@compiled_for_laws
def _no_force(distance: float, own: Any, mask: int) -> float:
    return 0.0


def sum_of_external_laws(laws: Sequence[BoundLaw], joined: Function) -> Function:
    """Return a compiled function (position, velocity, time, own, mask, out) that adds the accelerations of all laws in
    the mask to `out` (d,).
    """
    total = _no_acceleration
    for bit, law in enumerate(laws):
        total = _accelerating(compiled_for_laws(law.function), law.constants, 1 << bit, (total, joined))
    return total


def _accelerating(
    law: Function, constants: tuple[float, ...], flag: int, others: tuple[Function, Function]
) -> Function:
    rest, joined = others

    @compiled_for_laws
    def both(position: Any, velocity: Any, time: float, own: Any, mask: int, out: Any) -> None:
        rest(position, velocity, time, own, mask, out)
        if mask & flag:
            found = law(position, velocity, time, joined(own, constants))
            for axis in range(len(found)):
                out[axis] += found[axis]

    return both


@compiled_for_laws
def _no_acceleration(position: Any, velocity: Any, time: float, own: Any, mask: int, out: Any) -> None:
    pass


def _pair_of(rows: Any, i: int) -> tuple[float, float]:
    return rows[i, 0], rows[i, 1]


def _triple_of(rows: Any, i: int) -> tuple[float, float, float]:
    return rows[i, 0], rows[i, 1], rows[i, 2]


def row_as_tuple(dimensions: int) -> Function:
    """Return a compiled function (rows, i) -> row i as a tuple."""
    return compiled_for_laws(_pair_of if dimensions == 2 else _triple_of)


def called(law: BoundLaw, *arguments: Any) -> Any:
    """The value of a compiled law. Raises BadInput with the message of the compiler or of the function."""
    try:
        return compiled_for_laws(law.function)(*arguments)
    except Exception as error:  # a user function may raise any exception, and so may its compilation
        said = [line for line in str(error).splitlines() if line.strip() and not line.startswith("Failed in nopython")]
        why = said[0].strip() if said else type(error).__name__
        expected = KINDS[law.arguments].partition(" (")[2]
        raise BadInput(
            f"extra_laws: {law.name}: cannot be used: {why}; expected a plain function ({expected}, of numbers and the "
            "functions of math"
        ) from error


ROUNDING = 1e-12
"""Tolerated relative change of a force when i and j are exchanged: rounding only."""


def require_force(law: BoundLaw, distances: Sequence[float], one: Any, other: Any) -> None:
    """Evaluate a pair law with the parameters of two typical particles, and with the particles exchanged. Raises
    BadInput for an invalid result.
    """
    for distance in distances:
        forces = [called(law, distance, parameters) for parameters in (one, other)]
        for force in forces:
            if isinstance(force, bool) or not isinstance(force, (int, float)) or not math.isfinite(force):
                raise BadInput(f"extra_laws: {law.name}: got {force!r} at {distance:g} m; expected a force in N")
        if abs(forces[0] - forces[1]) > ROUNDING * max(map(abs, forces)):
            raise BadInput(
                f"extra_laws: {law.name}: at {distance:g} m, got forces of {forces[0]:.4g} N and {forces[1]:.4g} N on "
                "two unequal particles, which would create momentum; expected a force that is the same if i and j are "
                "exchanged, such as one of radius_i * radius_j"
            )


def require_acceleration(law: BoundLaw, position: tuple[float, ...], parameters: Any) -> None:
    """Evaluate an external law at one position. Raises BadInput for an invalid result."""
    found = called(law, position, tuple(0.0 for _ in position), 0.0, parameters)
    good = isinstance(found, tuple) and len(found) == len(position)
    if not good or not all(isinstance(value, float) and math.isfinite(value) for value in found):
        raise BadInput(
            f"extra_laws: {law.name}: got {found!r}; expected an acceleration in m/s^2, a tuple of {len(position)} "
            "numbers with decimal points"
        )


NODES, WEIGHTS = np.polynomial.legendre.leggauss(8)
PANELS = 8
"""The number of panels for the integral of a force over ln(distance)."""


def energy_between(force: Function) -> Function:
    """Return a compiled function (near, far, own, mask) -> the integral of the force from `near` to `far` (J), by
    Gauss-Legendre quadrature in the logarithm of the distance.
    """
    nodes, weights = NODES, WEIGHTS

    @compiled_for_laws
    def energy(near: float, far: float, own: Any, mask: int) -> float:
        width, total = math.log(far / near) / PANELS, 0.0
        for panel in range(PANELS):
            for k in range(len(nodes)):
                distance = near * math.exp((panel + 0.5 * (1.0 + nodes[k])) * width)
                total += 0.5 * width * weights[k] * distance * force(distance, own, mask)
        return total

    return energy
