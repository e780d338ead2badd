"""Runs of each model move between processors: the part of `sh scripts/processors` that every test run does."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from .moving import begin, faults, resume
from .settings import PROCESSORS, environment_of, same_code

pytestmark = pytest.mark.compiled
SCENES = ("bowl", "cereal-discs", "channel", "sheared-packing", "bouncing-tracers")
COMPILED_AGAIN = ("channel", "bouncing-tracers")
"""Where Numba compiles other code, which takes minutes for floats or the whole gallery: see `sh scripts/processors`."""
OTHERS = ("openblas-zen", "openblas-prescott", "numpy-baseline", "numba-generic")


def scenes_on(processor: str) -> tuple[str, ...]:
    """The scenes that are tried on a processor."""
    return SCENES if same_code("native", processor) else COMPILED_AGAIN


@pytest.fixture(scope="module")
def begun(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Runs that were begun on this processor as it is, and killed."""
    folder = tmp_path_factory.mktemp("begun") / "native"
    begin("native", folder, SCENES)
    return folder


@pytest.mark.long
@pytest.mark.timeout(900)
@pytest.mark.parametrize("processor", OTHERS)
def test_a_run_goes_on_on_any_processor(begun: Path, processor: str, tmp_path: Path) -> None:
    runs = resume(processor, begun, tmp_path / "copy", scenes_on(processor))
    assert len(runs) == len(scenes_on(processor))
    assert faults("native", processor, runs) == []


@pytest.mark.long
@pytest.mark.timeout(900)
def test_a_run_comes_back_from_the_oldest_processor(tmp_path: Path) -> None:
    scenes = scenes_on("all-of-it")
    begin("all-of-it", tmp_path / "old", scenes)
    assert faults("all-of-it", "native", resume("native", tmp_path / "old", tmp_path / "copy", scenes)) == []


PORTABLE = """
import hashlib, sys
import numpy as np
from ecume import _portable as p
random = np.random.default_rng(7)
x, m, n = random.normal(size=2000), random.normal(size=(3, 3)), random.normal(size=(3, 700))
found = [p.exp(x), p.log(abs(x)), p.sin(x), p.cos(x), p.power(abs(x), 6.0), p.sinc(x), p.phase_factor(x).view(float),
         p.product(m, n), p.dots(n, n), p.solve(m, n[:, 0]), [p.dot(x, x), p.length(x)]]
print(hashlib.sha256(b"".join(np.asarray(one, float).tobytes() for one in found)).hexdigest())
"""


@pytest.mark.long
def test_portable_functions_give_the_same_bits_on_any_processor() -> None:
    def bits(processor: str) -> str:
        environment = environment_of(processor)
        words = [sys.executable, "-c", PORTABLE]
        return subprocess.run(words, env=environment, capture_output=True, text=True, check=True).stdout

    assert len({bits(processor) for processor in PROCESSORS}) == 1


def test_the_settings_really_change_what_libraries_do() -> None:
    """Else the tests above would show nothing. NumPy's functions differ where the processor has AVX-512."""
    script = """
import hashlib
import numpy as np
random = np.random.default_rng(7)
matrix = random.normal(size=(60, 60))
print(hashlib.sha256(np.linalg.solve(matrix, matrix @ matrix).tobytes()).hexdigest())
"""
    native, old = (
        subprocess.run(
            [sys.executable, "-c", script],
            env=environment_of(processor),
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for processor in ("native", "openblas-prescott")
    )
    found = np.show_config(mode="dicts")["SIMD Extensions"].get("found", [])
    if "X86_V3" in found or "AVX2" in found:
        assert native != old
