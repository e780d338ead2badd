"""Scenes that once failed, each as reported: the files in `cases`."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from ecume.errors import SceneError
from ecume.models.soft import SOFT
from ecume.scenes.load import load_scene
from ecume.simulation import simulate

CASES = Path(__file__).parent / "cases"


def case(name, **changes):
    return dataclasses.replace(load_scene(CASES / f"{name}.toml"), **changes)


def missing(frames):
    """The residual of the energy budget, over the dissipated work."""
    first, *_, last = (frame.numbers for frame in frames)
    spent = last["dissipated_work"] + last["size_work"] + last["total_energy"] - first["total_energy"]
    return abs(last["injected_work"] - spent) / last["dissipated_work"]


@pytest.mark.compiled
def test_soft_jump_energy():
    """What a jump of the strain puts in is dissipated: 18 % too much was."""
    assert missing(list(simulate(case("soft_jump_energy")))) < 1e-3


@pytest.mark.compiled
@pytest.mark.long
def test_soft_oscillation_energy():
    """The budget missed 6.6e-3 of a small oscillation with drag, at any tolerance."""
    assert missing(list(simulate(case("soft_oscillation_energy")))) < 1e-4


@pytest.mark.long
@pytest.mark.compiled
def test_soft_rotation_drag_stress():
    """Rotation, drag and a shear stress together were refused; forces balance from the first frame on."""
    frames = list(simulate(case("soft_rotation_drag_stress", duration=0.4)))
    for frame in frames:
        assert frame.numbers["imbalance"] < 1e-7
        assert frame.numbers["shear_stress"] == pytest.approx(0.03, rel=1e-7)
        assert frame.numbers["normal_stress"] == pytest.approx(0.1, rel=1e-7)


@pytest.mark.compiled
def test_soft_loose_start_pressed():
    """It is refused with what helps, and that helps."""
    loose = case("soft_loose_start_pressed")
    with pytest.raises(SceneError, match=r"hydrodynamics.drag = 'stokes', a larger films.cutoff .*volume_fraction"):
        SOFT.start(loose, SOFT.parameters(loose))
    carried = dataclasses.replace(
        loose, hydrodynamics=dataclasses.replace(loose.hydrodynamics, drag="stokes"), duration=0.02, frame_every=0.01
    )
    assert [frame.numbers["pressure"] for frame in simulate(carried)] == pytest.approx([0.1] * 3, rel=1e-7)


@pytest.mark.compiled
@pytest.mark.long
def test_soft_iterative_solver():
    """The iterative solver gives way to a factorization where the matrix of a compressed packing defeats it."""
    end = list(simulate(case("soft_iterative_solver")))[-1]
    assert end.time == pytest.approx(3.0)
    assert end.numbers["imbalance"] < 1e-7


DIAMETERS = (
    2.990, 3.235, 3.096, 3.283, 3.301, 2.852, 2.811, 3.470, 3.007, 2.987, 3.597, 3.176, 3.469, 3.181, 3.311, 2.920,
)  # fmt: skip
"""mm, in `poly.data`"""


@pytest.mark.parametrize("model", ["soft", "floating", "tracers"])
def test_polydisperse_file(model):
    """A file with a diameter of each sphere gives each its own radius, in all models."""
    scene = case(f"poly_{model}")
    frame = next(iter(simulate(scene)))
    assert frame.arrays["radius"] == pytest.approx(5e-4 * np.array(DIAMETERS))
