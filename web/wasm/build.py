"""Writes the simulation of a page: build.py PYTHON FOLDER [MODULE ...]. PYTHON has the package ziglang.

See scripts/web.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from functools import partial
from pathlib import Path
from types import FunctionType
from typing import Any

import ecume._jit
import ecume._lowering

# A page has one thread. Said before any module is imported that has loops over threads.
ecume._jit.threaded = ecume._jit.spread = ecume._jit.compiled
ecume._jit.summing = partial(ecume._jit._dispatcher, cache=True, fastmath=ecume._jit.ANY_ORDER)
# Vectors of a page have 16 bytes. Those of this processor would spill, and bytes would depend on where they are made.
ecume._lowering._vector_bytes = lambda context: 16  # type: ignore[attr-defined]

import numba
import numpy as np
from numba_wasm import Entry, object_of

from ecume import _portable
from ecume._parts import overload
from ecume.engine import cells, neighbor_rows, root_finding
from ecume.laws import time_step_limits, water_waves
from ecume.models.floating.time_integration.integration import integrate, renew_lists
from ecume.models.soft import protocol
from ecume.models.soft.integration import step_control
from ecume.models.soft.report import energy_budget
from ecume.models.soft.t1 import cluster, cluster_steps
from ecume.models.sph import state as tank_state
from ecume.models.sph.boundaries import walls
from ecume.models.sph.integration import particle_loops
from ecume.scenes.load import load_scene
from ecume.scenes.templates import folder
from ecume.show.play import tank_steps
from ecume.show.play.bowl import swung_along
from ecume.show.play.four_spheres import cluster_arguments
from ecume.show.play.memory import bowl_arguments, types_of
from ecume.show.play.tank_alone import tank_arguments

HERE = Path(__file__).parent
FLAGS = ("--no-entry", "--strip-all", "--gc-sections", "--stack-first", "-z", "stack-size=1048576")
EXPORTS = ("memory_from", "__heap_base")


def without_folders(made: Any, filename: str, *rest: Any, **named: Any) -> None:
    """Name a place in a source from the folder of the project on: texts of errors have it, and bytes of modules would
    depend on the folders of this machine.
    """
    for place in (HERE.resolve().parents[1], Path(sys.prefix)):
        filename = filename.removeprefix(f"{place}/")
    LOCATED(made, filename, *rest, **named)


LOCATED = numba.core.ir.Loc.__init__
numba.core.ir.Loc.__init__ = without_folders


def bowl() -> dict[str, Any]:
    """The arguments of a bowl; those of another may have other values, but not other types."""
    return bowl_arguments(load_scene((folder() / "cereal-bowl.toml").read_text(encoding="utf-8")))


def of_bowl(arguments: dict[str, Any]) -> list[Entry]:
    """What the page of a bowl calls: steps, new neighbor lists, and the swing of the liquid."""
    kinds = tuple(map(numba.typeof, arguments.values()))
    number = numba.float64
    return [
        Entry("advance", integrate, kinds),
        Entry("renew", renew_lists, kinds[:-1]),
        Entry("swing", ecume._jit.compiled(swung_along), (number,) * 5),
    ]


def of_cluster(arguments: dict[str, Any]) -> list[Entry]:
    """What the page of four spheres calls: the forces at rest, and a step."""
    ecume._jit.admit(protocol, root_finding, step_control, energy_budget, cluster, cluster_steps)
    kinds = tuple(map(numba.typeof, arguments.values()))
    parts = {"begin": cluster_steps.begin, "follow": cluster_steps.follow_step}
    made = [Entry(name, ecume._jit.compiled(function), kinds) for name, function in parts.items()]
    return [*made, Entry("outcome", ecume._jit.compiled(cluster.outcome_at), (numba.float64,) * 3)]


@overload(_portable.product)
def _product(matrix: Any, vectors: Any) -> Any:
    """The product of a vector with rows, in the order of the original."""

    def of_rows(matrix: Any, vectors: Any) -> Any:
        total = matrix[0] * vectors[0]
        for k in range(1, len(matrix)):
            total = total + matrix[k] * vectors[k]
        return total

    return of_rows


@overload(_portable.dot)
def _dot(one: Any, other: Any) -> Any:
    return lambda one, other: np.sum(one * other)


def tank(precision: str = "double") -> dict[str, Any]:
    """The arguments of a tank."""
    text = (folder() / "small-tank.toml").read_text(encoding="utf-8")
    return tank_arguments(load_scene(text, [f'method.precision="{precision}"']))


def of_tank(arguments: dict[str, Any]) -> list[Entry]:
    """What the page of a tank calls: its beginning, steps, distances from walls, tilts, and pushes."""
    ecume._jit.admit(cells, neighbor_rows, time_step_limits, water_waves, tank_state, walls, particle_loops)
    # Functions of a whole tank once each: written out where they are called they are ten times as much code.
    for name, function in list(vars(tank_steps).items()):
        if isinstance(function, FunctionType) and function.__module__ == tank_steps.__name__:
            setattr(tank_steps, name, ecume._jit.compiled(function))
    kinds = tuple(map(numba.typeof, arguments.values()))
    parts = {
        "put": tank_steps.put_constant_fields, "gap": tank_steps.measure_gap, "lean": tank_steps.lean,
        "push": tank_steps.push_wall, "wall": tank_steps.measure_wall, "period": tank_steps.measure_period,
    }  # fmt: skip
    made = [Entry(name, function, kinds[:-1]) for name, function in parts.items()]
    return [*made, Entry("advance", tank_steps.advance, kinds)]


def run(*words: Any) -> None:
    """Run a command."""
    subprocess.run([str(word) for word in words], check=True)


INLINED = {"tank": 25, "tank-single": 25}
"""A step of a tank as one function takes LLVM several minutes."""
MODULES = {
    "bowl": (bowl, of_bowl), "t1": (cluster_arguments, of_cluster), "tank": (tank, of_tank),
    "tank-single": (partial(tank, "single"), of_tank),
}  # fmt: skip


def build(python: str, target: Path, only: list[str]) -> None:
    """Compile, and link with Zig's elementary functions, and musl's pow; all modules, or some."""
    zig = (python, "-m", "ziglang")
    found = subprocess.run([*zig, "env"], capture_output=True, text=True, check=True).stdout
    library = Path(next(line for line in found.splitlines() if "lib_dir" in line).split('"')[1])
    musl = library / "libc" / "musl"
    with tempfile.TemporaryDirectory() as name:
        work = Path(name)
        at = [HERE / "include", *(musl / part for part in ("src/math", "src/include", "src/internal", "include"))]
        searched = [f"-I{folder}" for folder in (*at, library / "libc" / "include" / "wasm-wasi-musl")]
        wasi = ("-target", "wasm32-wasi", "-nostdinc", "-isystem", library / "include")
        run(*zig, "cc", "-w", *wasi, "-O2", "-g0", "-c", HERE / "power.c", *searched, "-o", work / "pow.o")
        archive, functions = work / "libcompiler.a", work / "functions.o"
        options = ("-target", "wasm32-freestanding", "-O", "ReleaseFast", "-fstrip")
        run(*zig, "build-lib", library / "compiler_rt.zig", *options, "--name", "compiler", f"-femit-bin={archive}")
        run(*zig, "build-obj", HERE / "functions.zig", *options, f"-femit-bin={functions}")
        for module, (given, calls) in MODULES.items():
            if module not in (only or MODULES):
                continue
            arguments = given()
            made = calls(arguments)
            (target / f"{module}.types").write_text(types_of(arguments), encoding="utf-8")
            (work / f"{module}.o").write_bytes(object_of(made, INLINED.get(module)))
            exports = [f"--export={one}" for one in (*EXPORTS, *(entry.name for entry in made))]
            objects = (work / f"{module}.o", work / "pow.o", functions, archive)
            run(*zig, "wasm-ld", *FLAGS, *exports, *objects, "-o", target / f"{module}.wasm")


if __name__ == "__main__":
    build(sys.argv[1], Path(sys.argv[2]), sys.argv[3:])
