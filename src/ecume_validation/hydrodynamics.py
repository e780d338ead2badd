"""Floats with hydrodynamic interaction: rafts, pairs, diffusion and Boltzmann's weights."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator
from typing import Any

import numpy as np
from scipy.special import i1

from ecume.errors import EcumeError
from ecume.laws.brownian_motion import thermal_energy
from ecume.laws.drag import pair_factor
from ecume.laws.pair_mobility import compact_raft, raft_speed_factor, surface_mobility
from ecume.models import MODELS
from ecume.models.floating.time_integration.integration import forces_at
from ecume.models.floating.time_integration.step_size import StepWarning
from ecume.models.model import CROWDED, DONE
from ecume.scenes.schema import from_plain
from ecume.units import Array
from ecume_validation.runner import Row, below, within

RADIUS = 3e-4
SYRUP = {"density": 1000.0, "viscosity": 0.02, "surface_tension": 0.0728}
RAFTS = (7, 19, 37, 91)
GAPS = (0.01, 0.02, 0.05, 0.1, 0.5, 1.0, 2.0, 3.0, 4.0, 8.0, 18.0)
TOGETHER = {2.0: 0.05, 3.0: 0.025, 4.0: 0.01, 6.0: 0.01, 10.0: 0.01}
"""Distances of the centers of two spheres that move together, in R, and the tolerances."""
PACKINGS = 1000
STEPS = 40_000
"""Independent steps from one configuration."""
SMALL, TEMPERATURE = 1e-6, 300.0
"""Radius (m) of floats with thermal noise, and their temperature (K)."""
WELL, FRAMES, PER_FRAME = 5e-4, 15_000, 20
"""Radius of the dish that confines the float (m), frames, and steps per frame. The confinement is weak in the middle,
and steep at the rim.
"""


class Run:
    """A run of the floating model that can be advanced step by step."""

    def __init__(self, scene: dict[str, Any], **constants: float) -> None:
        self.model, given = MODELS["floating"], from_plain({"model": "floating", **scene})
        parameters = self.model.parameters(given)
        moving = parameters.parts.integrator._replace(**constants)
        self.parameters = parameters._replace(parts=parameters.parts._replace(integrator=moving))
        self.state = self.model.start(given, self.parameters)
        self.workspace = self.model.workspace(self.parameters, self.state, 1.0)

    def advance(self, steps: int) -> None:
        """Advance by this number of steps."""
        end, status = int(self.state.step[0]) + steps, CROWDED
        while status == CROWDED:
            status = self.model.advance(self.parameters, self.state, self.workspace, end - int(self.state.step[0]))
            if status == CROWDED:
                self.workspace = self.model.workspace(self.parameters, self.state, 2.0)
        if status != DONE:
            raise EcumeError("the run diverged")


def rows() -> list[Row]:
    """Compare rafts, pairs, packings, diffusion, and the distribution in a well."""
    return [*rafts(), *approaches(), *common_motions(), *packings(), *diffusion(), *weights()]


def scene_of(places: Array, *, lubrication: dict[str, float] | None = None, **rest: Any) -> dict[str, Any]:
    """Half-immersed heavy spheres in a viscous liquid."""
    bead = {"radius": RADIUS, "density": 1300.0, "contact_angle": math.pi / 2, "positions": places.tolist()}
    films = {"lubrication": lubrication} if lubrication else {}
    return {
        "duration": 1.0, "frame_every": 1.0, "liquid": SYRUP, "particles": [bead],
        "integration": {"integrator": "overdamped"},
        "hydrodynamics": {"interaction": "rotne-prager", **films}, **rest,
    }  # fmt: skip


def forces_of(run: Run, places: Array) -> Array:
    """The forces (N, 2) at these places."""
    return np.array(forces_at(run.parameters, np.ascontiguousarray(places), run.workspace))


def rafts() -> Iterator[Row]:
    """Compare the speeds of rafts that a distant wall attracts."""
    wall = {"size": [0.03, 0.08], "contact_angle": math.radians(90.2)}
    for count in RAFTS:
        places = RADIUS * compact_raft(count) + [0.006, 0.0]
        run = Run(scene_of(places, dish=wall))
        run.advance(2)
        single = forces_of(run, places)[:, 0].mean() * run.parameters.kick.gain[0]
        found = float(run.state.velocity[:, 0].mean() / single)
        expected = raft_speed_factor(count)
        yield within(f"raft of {count}: speed over that of one sphere", found, expected, 0.02 * expected)


def approaches() -> Iterator[Row]:
    """Compare the resistance of two approaching spheres, with lubrication films."""
    for gap in GAPS:
        places = RADIUS * np.array([[-1.0 - 0.5 * gap, 0.0], [1.0 + 0.5 * gap, 0.0]])
        run = Run(scene_of(places, lubrication={"roughness": 1e-8}))
        run.advance(1)
        single = forces_of(run, places)[0, 0] * run.parameters.kick.gain[0]
        slowness = float(single / run.state.velocity[0, 0])
        expected = float(pair_factor(2.0 + gap))
        name = f"approach at a gap of {gap:g} R: drag over that of one sphere"
        yield within(name, slowness, expected, 0.01 * expected)


def common_factor(distance: float) -> float:
    """The drag of each of two equal spheres that move together along their line of centers, over that of a single
    sphere; `distance` is that of the centers in radii, above 2.

    lambda = (4/3) sinh(a) sum_n n(n+1)/[(2n-1)(2n+3)] {1 - [4 sinh^2((n+1/2)a) - (2n+1)^2 sinh^2(a)] /
    [2 sinh((2n+1)a) + (2n+1) sinh(2a)]}, cosh(a) = l/2R. [stimson1926].
    """
    alpha = math.acosh(0.5 * distance)
    total = 0.0
    for n in range(1, math.ceil(30.0 / alpha) + 3):
        odd = 2.0 * n + 1.0
        # Divided by exp((2n+1) a), which would overflow.
        shrunk = math.exp(-odd * alpha)
        top = (1.0 - shrunk) ** 2 - (odd * math.sinh(alpha)) ** 2 * shrunk
        bottom = -math.expm1(-2.0 * odd * alpha) + odd * math.sinh(2.0 * alpha) * shrunk
        total += n * (n + 1.0) / ((odd - 2.0) * (odd + 2.0)) * (1.0 - top / bottom)
    return 4.0 / 3.0 * math.sinh(alpha) * total


def common_motions() -> Iterator[Row]:
    """Compare the drag of two spheres that move together, from the sums of their velocities and forces."""
    wall = {"size": [0.03, 0.08], "contact_angle": math.radians(90.2)}
    for distance, tolerance in TOGETHER.items():
        places = RADIUS * np.array([[-0.5 * distance, 0.0], [0.5 * distance, 0.0]]) + [0.006, 0.0]
        run = Run(scene_of(places, dish=wall, contacts={"law": "none"}))
        run.advance(1)
        single = float(forces_of(run, places)[:, 0].mean() * run.parameters.kick.gain[0])
        found = single / float(run.state.velocity[:, 0].mean())
        expected = common_factor(max(distance, 2.0 + 1e-5))
        name = f"two spheres that move together at a distance of {distance:g} R: drag over that of one"
        yield within(name, found, expected, tolerance * expected)


def packings() -> Iterator[Row]:
    """Count matrices that are not positive definite among those of random packings."""
    rng, failed = np.random.default_rng(7), 0
    for _ in range(PACKINGS):
        count = int(rng.integers(2, 25))
        radius, width = np.exp(rng.normal(0.0, 0.8, count)), 10.0 ** rng.uniform(-1.5, 1.5)
        mobility = surface_mobility(rng.normal(0.0, width, (count, 2)), radius, 1.0)
        failed += float(np.linalg.eigvalsh(mobility).min()) <= 0.0
    yield below(f"mobilities of {PACKINGS} packings that are not positive definite", float(failed), 0.5)


def brownian_scene(places: Array, **rest: Any) -> dict[str, Any]:
    """Small spheres with thermal noise and without other forces."""
    bead = {"radius": SMALL, "density": 4000.0, "contact_angle": math.pi / 2, "positions": places.tolist()}
    return {
        "duration": 10.0, "frame_every": 10.0, "particles": [bead], "seed": 3,
        "liquid": {"density": 1000.0, "viscosity": 1e-3, "surface_tension": 0.0728, "temperature": TEMPERATURE},
        "integration": {"integrator": "overdamped"}, "interaction": {"law": "none"}, "contacts": {"law": "none"},
        "hydrodynamics": {"interaction": "rotne-prager", "brownian": True}, **rest,
    }  # fmt: skip


def diffusion() -> Iterator[Row]:
    """Compare the displacements of a dimer and a trimer in single steps with 2 kT dt times the mobility."""
    corners = np.array([[0.0, 0.0], [2.0, 0.0], [1.0, math.sqrt(3.0)]])
    for count, name in ((2, "dimer"), (3, "trimer")):
        places = SMALL * corners[:count]
        run = Run(brownian_scene(places))
        moved = np.empty((STEPS, 2 * count))
        for step in range(STEPS):
            run.state.position[:] = places
            run.advance(1)
            moved[step] = (run.state.position - places).ravel()
        mobility = surface_mobility(places, np.full(count, SMALL), 1e-3)
        unit = 2.0 * thermal_energy(TEMPERATURE) * run.parameters.time_step
        modes = {f"center along {axis}": np.tile(way, count) / count for axis, way in zip("xy", np.eye(2), strict=True)}
        if count == 2:
            modes["distance"] = np.array([-1.0, 0.0, 1.0, 0.0])
        for which, mode in modes.items():
            ratio = float(np.var(moved @ mode) / (unit * (mode @ mobility @ mode)))
            yield within(f"diffusion of a {name}, {which}: over kT times its mobility", ratio, 1.0, 0.03)


def weights() -> Iterator[Row]:
    """Compare the mean square distance from the center of a well, with and without the drift kT div M."""
    name = "mean square distance of eight spheres in a well, over kT/k"
    yield within(name, spread_in_a_well(), 1.0, 0.06)
    yield below(f"{name}, without the drift kT div M", spread_in_a_well(thermal=0.0), 0.85)


def spread_in_a_well(**constants: float) -> float:
    """The mean square distance along an axis, over kT/k."""
    places = 3.0 * SMALL * compact_raft(8)
    step = {"integrator": "overdamped", "time_step": 0.02}
    dish = {"radius": WELL, "contact_angle": math.radians(10.0)}
    with warnings.catch_warnings():
        # The step recommended by the warning is for floats at the rim.
        warnings.simplefilter("ignore", StepWarning)
        run = Run(brownian_scene(places, dish=dish, integration=step), **constants)
    length = float(run.parameters.pair[1])
    spring = 0.5 * float(run.parameters.wall_strength[0, 0]) / length**2 / float(i1(WELL / length))
    squares = []
    for _ in range(FRAMES):
        run.advance(PER_FRAME)
        squares.append(float(np.mean(run.state.position**2)))
    return float(np.mean(squares[FRAMES // 10 :])) * spring / thermal_energy(TEMPERATURE)
