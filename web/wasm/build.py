"""Writes the simulation of a page: build.py PYTHON FOLDER, where PYTHON has the package ziglang. See scripts/web."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import ecume._jit

# A page has one thread. Said before any module is imported that has loops over threads.
ecume._jit.threaded = ecume._jit.compiled

import numba
from numba_wasm import Entry, object_of

from ecume.models.floating.time_integration.integration import integrate, renew_lists
from ecume.scenes.load import load_scene
from ecume.scenes.templates import folder
from ecume.show.play.bowl import swung_along
from ecume.show.play.memory import bowl_arguments, types_of

HERE = Path(__file__).parent
FLAGS = ("--no-entry", "--strip-all", "--gc-sections", "--stack-first", "-z", "stack-size=1048576")
EXPORTS = ("memory_from", "__heap_base")


def bowl() -> dict[str, Any]:
    """The arguments of a bowl; those of another may have other values, but not other types."""
    return bowl_arguments(load_scene((folder() / "cereal-bowl.toml").read_text(encoding="utf-8")))


def entries(arguments: dict[str, Any]) -> list[Entry]:
    """What a page calls: steps, new neighbor lists, and the swing of the liquid."""
    kinds = tuple(map(numba.typeof, arguments.values()))
    number = numba.float64
    return [
        Entry("advance", integrate, kinds),
        Entry("renew", renew_lists, kinds[:-1]),
        Entry("swing", ecume._jit.compiled(swung_along), (number,) * 5),
    ]


def run(*words: Any) -> None:
    """Run a command."""
    subprocess.run([str(word) for word in words], check=True)


def build(python: str, target: Path) -> None:
    """Compile, and link with Zig's exp, log, sin and cos, and musl's pow."""
    zig = (python, "-m", "ziglang")
    found = subprocess.run([*zig, "env"], capture_output=True, text=True, check=True).stdout
    library = Path(next(line for line in found.splitlines() if "lib_dir" in line).split('"')[1])
    musl = library / "libc" / "musl"
    with tempfile.TemporaryDirectory() as name:
        arguments = bowl()
        work, made = Path(name), entries(arguments)
        (target / "bowl.types").write_text(types_of(arguments), encoding="utf-8")
        (work / "bowl.o").write_bytes(object_of(made))
        at = [HERE / "include", *(musl / part for part in ("src/math", "src/include", "src/internal", "include"))]
        searched = [f"-I{folder}" for folder in (*at, library / "libc" / "include" / "wasm-wasi-musl")]
        wasi = ("-target", "wasm32-wasi", "-nostdinc", "-isystem", library / "include")
        run(*zig, "cc", "-w", *wasi, "-O2", "-g0", "-c", HERE / "power.c", *searched, "-o", work / "pow.o")
        archive = work / "libcompiler.a"
        source = library / "compiler_rt.zig"
        options = ("-target", "wasm32-freestanding", "-O", "ReleaseFast", "-fstrip")
        run(*zig, "build-lib", source, *options, "--name", "compiler", f"-femit-bin={archive}")
        exports = [f"--export={one}" for one in (*EXPORTS, *(entry.name for entry in made))]
        run(*zig, "wasm-ld", *FLAGS, *exports, work / "bowl.o", work / "pow.o", archive, "-o", target / "bowl.wasm")


if __name__ == "__main__":
    build(sys.argv[1], Path(sys.argv[2]))
