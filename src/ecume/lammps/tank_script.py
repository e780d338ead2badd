"""The files of the deck of a tank."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ecume.lammps.tanks import Tank, box_of
from ecume.units import Array

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
    yield f"# {tank.scene.title or 'Tank'}, written by ecume: see README.md. Run it in this folder:"
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
    """Gravity, mirrored for mirror images, and the repulsion of walls at short distances."""
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
    """The acceleration at this distance from a wall: see `ecume.laws.wall_forces`."""
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
    """The README: units, what is exact, what is approximated."""
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
- Impacts on walls: not braked; the first particles of a jet have higher pressures.
- Time: steps of {tank.parameters.time_step:.4g} s, half of those of ecume. LAMMPS does not divide steps.
"""
