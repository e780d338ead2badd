"""Tanks in LAMMPS: expressible features, numbers in reduced units, and the files of a deck.

Like ecume, the package RHEO has a Tait pressure, artificial and laminar viscosity, and a density diffusion. It has no
mirror walls. A deck therefore contains the whole liquid behind each wall as a second, mirrored liquid, for which
gravity is mirrored as well: by symmetry, the plane between them is a free-slip wall. Opposite walls make the box
periodic with twice the size of the tank.

Lengths are in spacings, densities over that of the liquid, and speeds over that of sound, so that the volume of a
particle is about 1. Forces of `pair_style rheo` contain the volume of one of the two particles only (release of 22
July 2025): they are right in these units alone.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ecume.laws.kernels import kernel
from ecume.models.sph.boundaries.walls import speed_of
from ecume.models.sph.parameters import Parameters
from ecume.models.sph.record import checked_parameters, start
from ecume.models.sph.setup.choices import (
    artificial_viscosity_of,
    filled,
    kernel_of,
    shifting_of,
    sides_of,
    smoothing_of,
    tension_of,
    turbulent,
)
from ecume.models.sph.state import State
from ecume.models.step_counts import last_step
from ecume.scenes.sph import SphScene
from ecume.units import Array
from ecume_lammps.expressible import Expressible
from ecume_lammps.script import in_a_comment

if TYPE_CHECKING:
    from ecume.scenes.sph.tank import SideSpec


SHORTER = 2
"""Steps per step of ecume: LAMMPS does not subdivide steps when forces are large."""

QUINTIC = "quintic-spline"
"""The kernel of the deck."""

WALL, OPEN, PERIODIC = "wall", "open", "periodic"


def _kinds(scene: SphScene) -> str:
    """The kinds of sides of the scene that a deck cannot express."""
    return ", ".join(sorted({side.kind for side in sides_of(scene)} - {WALL, OPEN, PERIODIC})) or "none"


def _sticks(scene: SphScene) -> bool:
    def no_slip(side: SideSpec) -> bool:
        return side.slip == "no-slip" or (side.slip is None and scene.liquid.sticks)

    return any(side.kind == WALL and no_slip(side) for side in sides_of(scene))


def _moves(scene: SphScene) -> bool:
    return any(side.motion is not None or side.velocity is not None for side in sides_of(scene))


def _solids(scene: SphScene) -> int:
    return len(scene.obstacles) + len(scene.bodies)


def _masses(scene: SphScene) -> bool:
    return any(region.particles is not None and bool(region.particles.masses) for region in scene.fluid)


def _none(got: Any) -> bool:
    return not got


TANKS = (
    Expressible("method.pressure", lambda scene: scene.method.pressure, lambda name: name == "tait", "tait",
                "fix rheo/pressure is an equation of state"),
    Expressible("liquid.tait_exponent", lambda scene: scene.liquid.tait_exponent, lambda got: got == 7.0, "7",
                "that of `tait/water`"),
    Expressible("method.pressure_force", lambda scene: scene.method.pressure_force, lambda name: name == "sum", "sum",
                "pair_style rheo has this form only"),
    Expressible("method.acoustic_damping", lambda scene: scene.method.acoustic_damping, _none, "0, or no key",
                "RHEO has no bulk viscosity"),
    Expressible("method.pressure_split", lambda scene: scene.method.pressure_split, lambda name: name == "none",
                "none", "gravity acts on the particles of the deck"),
    Expressible("method.shifting", shifting_of, lambda name: name == "none", "none",
                "another method of shifting would replace it"),
    Expressible("method.surface_tension_model", tension_of, lambda name: name == "none", "none",
                "RHEO has no surface tension"),
    Expressible("method.turbulence", turbulent, _none, "none", "RHEO has no eddy viscosity"),
    Expressible("second_liquid", lambda scene: scene.second_liquid is not None, _none, "false, that is, none",
                "the deck has one density and one speed of sound"),
    Expressible("liquid.rheology", lambda scene: scene.liquid.rheology is not None, _none, "false, that is, none",
                "other laws of RHEO would replace it"),
    Expressible("tank.walls", lambda scene: scene.tank.walls, lambda name: name == "mirror", "mirror",
                "walls of the deck are planes of symmetry"),
    Expressible("tank", _kinds, lambda name: name == "none", "walls, open and periodic sides",
                "the number of particles is constant"),
    Expressible("tank.slip", _sticks, _none, "false, that is, slip = 'free' at each wall",
                "walls of the deck are planes of symmetry"),
    Expressible("tank.motion", _moves, _none, "false, that is, walls at rest",
                "walls of the deck are planes of symmetry"),
    Expressible("base_excitation", lambda scene: scene.base_excitation is not None, _none, "false, that is, none",
                "gravity of the deck is constant"),
    Expressible("roll", lambda scene: scene.roll is not None, _none, "false, that is, none",
                "gravity of the deck is constant"),
    Expressible("central_force", lambda scene: scene.central_force is not None, _none, "false, that is, none",
                "gravity of the deck is uniform"),
    Expressible("obstacles", _solids, _none, "no obstacles and no bodies", "walls of the deck are planes of symmetry"),
    Expressible("passive_tracers", lambda scene: len(scene.passive_tracers), _none, "none",
                "nothing in RHEO is carried along"),
    Expressible("fluid.particles.masses", _masses, _none, "false, that is, particles of one mass",
                "each mass would be an atom type"),
    Expressible("user_laws", lambda scene: len(scene.user_laws), _none, "none",
                "its function is not part of the scene"),
)  # fmt: skip
"""All choices of a scene that LAMMPS may lack."""


class Axis(NamedTuple):
    """One axis of the tank."""

    plane: float
    """m: the plane of symmetry, or the origin"""
    side: int
    """side of the plane on which the liquid is: 1 or -1; 0 without a plane"""
    period: float
    """m: of the box; zero if not periodic"""


class Tank(NamedTuple):
    """All numbers of the deck of a tank, in reduced units unless a unit is given."""

    scene: SphScene
    parameters: Parameters
    """with the time step of the deck (s)"""
    axes: tuple[Axis, ...]
    position: Array
    """(N copies, d), first those of the liquid"""
    velocity: Array
    density: Array
    mass: float
    length: float
    """m: one spacing"""
    time: float
    """s: the time in which sound travels one spacing"""
    reach: float
    """of the kernel of the deck"""
    artificial_viscosity: float
    viscosity: float
    diffusivity: float
    gravity: Array
    standoff: float
    """range of the repulsion by walls"""
    repulsion: float
    """acceleration per depth inside this range"""
    time_step: float
    steps: int
    steps_per_frame: int


def parameters_for(scene: SphScene) -> Parameters:
    """The parameters of a tank with the time step of its deck. Raises SceneError."""
    made = checked_parameters(scene)
    return made._replace(time_step=made.time_step / SHORTER, steps_per_frame=made.steps_per_frame * SHORTER)


def tank_of(scene: SphScene, parameters: Parameters | None = None, state: State | None = None) -> Tank:
    """The numbers of a deck that starts from a state; default: that of the scene. Raises SceneError."""
    parameters = parameters_for(scene) if parameters is None else parameters
    state = start(scene, parameters) if state is None else state
    material, length = parameters.material, scene.spacing
    time, axes = length / material.sound_speed, axes_of(scene)
    place = state.position.T - np.array([axis.plane for axis in axes])
    position, velocity = mirrored(axes, place / length), mirrored(axes, state.velocity.T / material.sound_speed)
    return Tank(
        scene=scene,
        parameters=parameters,
        axes=axes,
        position=position,
        velocity=velocity,
        density=np.tile(state.density / material.density, len(position) // len(state.density)),
        mass=float(state.mass.mean()) / (material.density * length**parameters.dimension),
        length=length,
        time=time,
        reach=reach_of(scene) / length,
        artificial_viscosity=artificial_viscosity_of(scene),
        viscosity=(filled(scene.liquid).viscosity or 0.0) / (material.density * material.sound_speed * length),
        diffusivity=scene.method.diffusion_coefficient * smoothing_of(scene) / length,
        gravity=parameters.gravity * time**2 / length,
        standoff=parameters.boundary.guard.reach / length,
        repulsion=(speed_of(parameters) * time / parameters.boundary.guard.reach) ** 2,
        time_step=parameters.time_step / time,
        steps=last_step(scene, parameters.steps_per_frame),
        steps_per_frame=parameters.steps_per_frame,
    )


def reach_of(scene: SphScene) -> float:
    """The support radius (m) of the quintic spline with the standard deviation of the kernel of the scene.

    With the same support it would be narrower by an eighth, and the front of a dam break faster.
    """
    ours, theirs = kernel_of(scene), kernel(QUINTIC, dim=len(scene.tank.low))
    return theirs.support * smoothing_of(scene) * ours.standard_deviation / theirs.standard_deviation


def axes_of(scene: SphScene) -> tuple[Axis, ...]:
    """The axes of a tank: mirrored at one wall, and periodic between two."""
    sides, found = sides_of(scene), []
    for number, (low, high) in enumerate(zip(scene.tank.low, scene.tank.high, strict=True)):
        first, last = (side.kind == WALL for side in sides[2 * number : 2 * number + 2])
        size = high - low
        if first:
            found.append(Axis(low, 1, 2.0 * size if last else 0.0))
        elif last:
            found.append(Axis(high, -1, 0.0))
        else:
            found.append(Axis(low, 0, size if sides[2 * number].kind == PERIODIC else 0.0))
    return tuple(found)


def mirrored(axes: tuple[Axis, ...], vectors: Array) -> Array:
    """These vectors (N, d), relative to the planes, and all of their mirror images."""
    signs = itertools.product(*[(1.0, -1.0) if axis.side else (1.0,) for axis in axes])
    return np.concatenate([vectors * np.array(sign) for sign in signs])


def folded(axes: tuple[Axis, ...], position: Array, velocity: Array) -> tuple[Array, Array]:
    """Positions (N, d) inside the tank, and velocities: a particle beyond a wall is replaced by its mirror image."""
    position, velocity = position.copy(), velocity.copy()
    for k, axis in enumerate(axes):
        if axis.side:
            if axis.period:
                position[:, k] -= axis.period * np.round(position[:, k] / axis.period)
            beyond = axis.side * position[:, k] < 0.0
            position[beyond, k] *= -1.0
            velocity[beyond, k] *= -1.0
        elif axis.period:
            position[:, k] -= axis.period * np.floor(position[:, k] / axis.period)
        position[:, k] += axis.plane
    return position, velocity


BEYOND = 2.0
"""The distance from the liquid to the ends of a box that is not periodic, in support radii."""


def box_of(tank: Tank) -> list[tuple[float, float]]:
    """The low and high ends of the box along three axes."""
    found = []
    for k, axis in enumerate(tank.axes):
        period, width = axis.period / tank.length, BEYOND * tank.reach
        if period:
            found.append((-0.5 * period, 0.5 * period) if axis.side else (0.0, period))
        else:
            found.append((float(tank.position[:, k].min()) - width, float(tank.position[:, k].max()) + width))
    return found + [(-BEYOND * tank.reach, BEYOND * tank.reach)] * (3 - len(found))


DATA = "tank.data"


def data_text(tank: Tank) -> str:
    """The data file: box, atoms of the style `rheo`, velocities."""
    count = len(tank.position)
    numbers, places, speeds = range(1, count + 1), _in_space(tank.position), _in_space(tank.velocity)
    ends = zip(box_of(tank), "xyz", strict=True)
    atoms = zip(numbers, tank.density.tolist(), *places.T.tolist(), strict=True)
    return "\n".join(
        [
            "Tank, written by ecume; reduced units",
            "",
            f"{count} atoms",
            "1 atom types",
            "",
            *(f"{low!r} {high!r} {name}lo {name}hi" for (low, high), name in ends),
            "",
            "Atoms  # rheo",
            "",
            *(f"{n} 1 0 {density!r} {x!r} {y!r} {z!r}" for n, density, x, y, z in atoms),
            "",
            "Velocities",
            "",
            *(f"{n} {vx!r} {vy!r} {vz!r}" for n, vx, vy, vz in zip(numbers, *speeds.T.tolist(), strict=True)),
            "",
        ]
    )


def _in_space(vectors: Array) -> Array:
    return np.concatenate([vectors, np.zeros((len(vectors), 3 - vectors.shape[1]))], axis=1)


def setup_text(tank: Tank) -> str:
    """The commands before the first time step."""
    return "\n".join([*_style(tank), "", *_liquid(tank), "", *_forces(tank)]) + "\n"


def script_text(tank: Tank) -> str:
    """The input script."""
    return "\n".join([*_head(tank), setup_text(tank), *_output(tank)]) + "\n"


def _head(tank: Tank) -> Iterator[str]:
    yield f"# {in_a_comment(tank.scene.title or 'Tank')}, written by ecume: see README.md. Run it in this folder:"
    yield "#   lmp -in in.lammps    or    mpiexec -n 8 lmp -in in.lammps"
    yield "# Reduced units: spacing, speed of sound, density of the liquid."


def _style(tank: Tank) -> Iterator[str]:
    bounds = ["p" if axis.period else "m" for axis in tank.axes] + ["p"] * (3 - len(tank.axes))
    yield "units           lj"
    yield f"dimension       {len(tank.axes)}"
    yield f"boundary        {' '.join(bounds)}"
    yield "atom_style      rheo"
    yield "newton          off"
    yield "comm_modify     vel yes"
    yield f"read_data       {DATA}"


def _liquid(tank: Tank) -> Iterator[str]:
    count = len(tank.position) // (2 ** sum(axis.side != 0 for axis in tank.axes))
    yield f"mass            1 {tank.mass!r}"
    yield f"group           liquid id 1:{count}"
    artificial = f" artificial/visc {tank.artificial_viscosity!r}" if tank.artificial_viscosity else ""
    yield f"pair_style      rheo {tank.reach!r}{artificial} rho/damp {tank.diffusivity!r}"
    yield "pair_coeff      * *"
    yield f"neighbor        {0.1 * tank.reach!r} bin"
    yield "neigh_modify    every 1 delay 0 check yes"
    yield f"fix             liquid all rheo {tank.reach!r} quintic 0 density 1.0 speed/sound 1.0"
    yield f"fix             viscosity all rheo/viscosity * constant {tank.viscosity!r}"
    yield "fix             pressure all rheo/pressure * tait/water"
    yield "compute         density all rheo/property/atom rho"


def _forces(tank: Tank) -> Iterator[str]:
    """The commands for gravity, mirrored for mirror images, and for the repulsion of walls at short distances."""
    names = []
    for value, axis, name in zip(tank.gravity.tolist(), tank.axes, "xyz", strict=False):
        terms = [repr(value)] if value else []
        if axis.side:
            yield f"variable        above_{name} atom 2*({name}>0)-1"
            terms = [f"({axis.side * value!r})*v_above_{name}"] if value else []
            terms += [f"v_above_{name}*({_repulsion(tank, f'abs({name})')})"]
        if axis.side and axis.period:
            other = repr(0.5 * axis.period / tank.length)
            terms += [f"v_above_{name}*(-1)*({_repulsion(tank, f'({other}-abs({name}))')})"]
        yield f"variable        pull_{name} atom mass*({'+'.join(terms) or '0.0'})"
        names.append(f"v_pull_{name}")
    yield f"fix             pull all addforce {' '.join([*names, '0.0'][:3])}"
    if len(tank.axes) == 2:
        yield "fix             flat all enforce2d"
    yield f"timestep        {tank.time_step!r}"


def _repulsion(tank: Tank, gap: str) -> str:
    """The formula of the repulsive acceleration at a distance from a wall: see `ecume.laws.wall_forces`."""
    return f"{tank.repulsion!r}*({tank.standoff!r}-{gap})*({gap}<{tank.standoff!r})"


def _output(tank: Tank) -> Iterator[str]:
    yield f"variable        steps index {tank.steps}"
    yield f"variable        frame index {tank.steps_per_frame}"
    yield "thermo_style    custom step time ke"
    yield "thermo_modify   lost error"
    yield "thermo          ${frame}"
    yield "dump            frames liquid custom ${frame} frames.dump id type x y z vx vy vz c_density"
    yield "dump_modify     frames sort id format float %.17g time yes"
    yield "run             ${steps}"


def readme_text(tank: Tank) -> str:
    """The README: units, and a list of exact and approximate parts."""
    copies = 2 ** sum(axis.side != 0 for axis in tank.axes)
    planes = ", ".join(f"{name} = {axis.plane:g} m" for axis, name in zip(tank.axes, "xyz", strict=False) if axis.side)
    return f"""# {tank.scene.title or "Tank"}: a deck for LAMMPS

Written by ecume. It needs the package RHEO (tested with the release of 22 July 2025).

    lmp -in in.lammps
    mpiexec -n 8 lmp -in in.lammps

| file | contents |
|---|---|
| `in.lammps` | the input script; `-var steps N` and `-var frame N` change its steps |
| `{DATA}` | positions, velocities and densities |
| `frames.dump` | written by LAMMPS: positions, velocities and densities of the liquid, without mirror images |

## Units

| quantity | unit |
|---|---|
| length | {tank.length:.9g} m, one spacing |
| time | {tank.time:.9g} s, in which sound moves by one spacing |
| density | {tank.parameters.material.density:.9g} kg/m^3 |

Positions are relative to the planes of the mirrored walls ({planes or "none"}).

## Exact

- Initial positions, velocities and densities, gravity, Tait's equation with exponent 7: the same numbers.
- Free-slip walls: the liquid is mirrored at each wall, with mirrored gravity:
  {copies} copies of {len(tank.position) // copies} particles. By symmetry no liquid flows through the planes between.
- The repulsion of walls at less than {tank.standoff:.4g} spacings.

## Approximated

- Kernel: the quintic spline of RHEO with the standard deviation of the scene's kernel.
- Mass: all particles have the mean one. In ecume, particles that start under pressure are heavier, by less than 1 %.
- Artificial viscosity: the same coefficient, but only for the part of the relative velocity that the velocity gradient
  does not explain.
- Density diffusion: Molteni's, with the diffusivity of the scene's `method.diffusion_coefficient`. ecume subtracts the
  hydrostatic part.
- Laminar viscosity: that of RHEO, with the viscosity of the scene.
- Impacts on walls: neither braked nor damped; the first particles of a jet have higher pressures, and ring.
- Time: steps of {tank.parameters.time_step:.4g} s, half of those of ecume. LAMMPS does not divide steps.
"""
