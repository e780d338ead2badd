"""The processors that this one can be made to look like."""

from __future__ import annotations

import os
import platform
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np

ROOT = Path(__file__).parents[2]


def _found() -> str:
    """The optional instruction sets that NumPy uses here."""
    return " ".join(np.show_config(mode="dicts")["SIMD Extensions"].get("found", []))


PROCESSORS: dict[str, dict[str, str]] = {
    "native": {},
    "openblas-prescott": {"OPENBLAS_CORETYPE": "Prescott"},
    "openblas-haswell": {"OPENBLAS_CORETYPE": "Haswell"},
    "openblas-zen": {"OPENBLAS_CORETYPE": "Zen"},
    "openblas-skylakex": {"OPENBLAS_CORETYPE": "SkylakeX"},
    "numpy-baseline": {"NPY_DISABLE_CPU_FEATURES": _found()},
    "numba-generic": {"NUMBA_CPU_NAME": "generic"},
    "all-of-it": {
        "OPENBLAS_CORETYPE": "Prescott",
        "NPY_DISABLE_CPU_FEATURES": _found(),
        "NUMBA_CPU_NAME": "generic",
    },
}
"""The environment variables that make the libraries compute as on another processor. The last one is as different
as can be: what libraries would do on the oldest processor that they support."""


def environment_of_the_plain_pass() -> dict[str, str]:
    """What makes the libraries compute as on the oldest processors of this kind, for tests that compile nothing."""
    found = {} if platform.machine() not in ("x86_64", "AMD64") else PROCESSORS["openblas-prescott"]
    return found | PROCESSORS["numpy-baseline"]


def same_code(one: str, other: str) -> bool:
    """Whether Numba compiles the same code on both."""
    return PROCESSORS[one].get("NUMBA_CPU_NAME") == PROCESSORS[other].get("NUMBA_CPU_NAME")


def environment_of(processor: str) -> dict[str, str]:
    """The settings of one processor and of no other: "native" is always the machine itself."""
    others = {name for settings in PROCESSORS.values() for name in settings}
    return {**{name: value for name, value in os.environ.items() if name not in others}, **PROCESSORS[processor]}


def on(processor: str, words: Sequence[str], **options: object) -> subprocess.CompletedProcess[str]:
    """Run Python with these words on a processor."""
    path = os.pathsep.join([str(ROOT), str(ROOT / "src"), os.environ.get("PYTHONPATH", "")])
    environment = {**environment_of(processor), "PYTHONPATH": path}
    return subprocess.run([sys.executable, *words], env=environment, cwd=ROOT, text=True, check=False, **options)  # type: ignore[call-overload,no-any-return]


if __name__ == "__main__":
    for name, value in environment_of_the_plain_pass().items():
        print(f"export {name}='{value}'")
