"""The reason why forces or stresses have no balance: films do not percolate across the cell, the network is floppy, or
a force is too large.

Films that lead from a sphere to its own periodic image wind around the cell. Only films that wind around it along y
resist a normal stress or a shear stress there. A network that winds around the cell may still be floppy, if its spheres
can move or roll without deflections. Both are tested in the initial state, where deflections are zero and only the
network matters.
"""

from __future__ import annotations

from collections import deque

import numpy as np

from ecume.engine.cells import Integers
from ecume.models.soft.cell import WIDTH, StageTarget
from ecume.models.soft.contacts.contact_list import wall_films
from ecume.models.soft.integration.linear_solvers import begin_step
from ecume.models.soft.integration.newton import assemble_jacobian, fill_borders
from ecume.models.soft.parameters import Parameters
from ecume.models.soft.protocol import Drive, Rules
from ecume.models.soft.report.observation import SIDE_NAMES
from ecume.models.soft.state import State, Step, Workspace
from ecume.units import Array, with_prefix

HELD = 1e-9
"""The stiffness added to each unknown, over the mean stiffness, so that a floppy network has a small resistance."""
FLOPPY = 1e-6
"""The ratio to the resistance against an affine deformation below which only the added stiffness resists."""
YIELDING = 1e4
"""The ratio to the work in a network of mean stiffness above which forces mostly act on the added stiffness."""
MOST = 6000
"""The largest number of unknowns of a network that is tested."""


def windings(state: State) -> Integers:
    """The winding numbers of closed loops of films around each axis of the box, (L, d), without
    loops inside the box.
    """
    count, contacts = len(state.position), int(state.contacts[0])
    ties: list[list[tuple[int, Integers]]] = [[] for _ in range(count)]
    for (i, j), image in zip(state.pair[:contacts].tolist(), state.image[:contacts], strict=True):
        ties[i].append((j, image))
        ties[j].append((i, -image))
    box: list[Integers | None] = [None] * count
    found: list[Integers] = []
    for first in range(count):
        if box[first] is not None:
            continue
        box[first], waiting = np.zeros(state.image.shape[1], np.int64), deque([first])
        while waiting:
            i = waiting.popleft()
            for j, image in ties[i]:
                there = box[i] + image  # type: ignore[operator]
                if (known := box[j]) is None:
                    box[j] = there
                    waiting.append(j)
                elif (there != known).any():
                    found.append(there - known)
    rows: Integers = np.unique(np.array(found, np.int64).reshape(-1, state.image.shape[1]), axis=0)
    return rows


def unjoined(parameters: Parameters, state: State, rules: Rules) -> str:
    """The stress that no films bear, since none wind around the cell in its direction; empty if films bear all
    stresses.

    With drag, the liquid bears the stresses.
    """
    if parameters.drag.any() or not any(rules):
        return ""
    around = windings(state)
    along = [bool(around[:, axis].any()) for axis in range(around.shape[1])]
    if rules.strain and not along[1]:
        return "shear stress"
    pressed = [along[axis] for axis in range(len(along)) if rules[WIDTH + axis]]
    return ("pressure" if rules.width else "normal stress") if pressed and not any(pressed) else ""


def floppy(parameters: Parameters, state: State, scratch: Workspace, at: tuple[Drive, Rules]) -> str:
    """A sentence if the spheres can move without deflections under a controlled stress of the cell, otherwise empty."""
    return without_deflection(parameters, scratch, at) if any(at[1]) else ""


def without_deflection(parameters: Parameters, scratch: Workspace, at: tuple[Drive, Rules]) -> str:
    """A sentence if the spheres can move without deflections under a controlled stress of the cell or of walls,
    otherwise empty.

    The criterion is the smallest resistance after the spheres have moved, over that to an affine deformation. Large
    systems are not tested.
    """
    step, (drive, rules) = scratch.step, at
    if parameters.drag.any() or not (any(rules) or len(parameters.walls.free)) or step.bodies.right.size > MOST:
        return ""
    drive = drive._replace(shear_stress=0.0, normal_stress=0.0)
    begin_step(parameters, step, drive)
    step.cell.rules[:] = rules
    assemble_jacobian(step, 0.0)
    count = fill_borders(step, StageTarget(drive, drive, 0.0, 0.0))
    columns = step.borders.right[1 : 1 + count].reshape(count, -1)
    rows, corner = step.borders.rows[:count].reshape(count, -1), step.borders.corner[:count, :count]
    left = np.array(corner + rows @ _softened(scratch, columns).T)
    if np.abs(np.linalg.eigvals(np.linalg.solve(corner, left))).min() >= FLOPPY:
        return ""
    how = "move past each other or roll" if parameters.torque.shape[1] else "move past each other"
    return f"the films bear no stress, however small: spheres {how} with no film deflected; {remedies(parameters)}"


def unresisted(parameters: Parameters, state: State, scratch: Workspace, drive: Drive) -> str:
    """A sentence if a force that starts with the load would roll spheres without resistance of any film; otherwise
    empty.

    Forces that act from the start have already moved the spheres.
    """
    if drive.load != 0.0 or not (parameters.force.any() or parameters.torque.any()):
        return ""
    return rolling(parameters, scratch, drive, 1.0)


def rolling(parameters: Parameters, scratch: Workspace, drive: Drive, load: float) -> str:
    """A sentence if no film resists the forces at this load, otherwise empty.

    The criterion is the work of the forces in the network with a small added stiffness, over that in one with the mean
    stiffness.
    """
    pull = np.concatenate([load * parameters.force + parameters.weight, load * parameters.torque], axis=1)
    if parameters.drag.any() or not parameters.torque.shape[1] or not pull.any() or pull.size > MOST:
        return ""
    step = scratch.step
    begin_step(parameters, step, drive)
    assemble_jacobian(step, 0.0)
    work = float((pull.ravel() * _softened(scratch, pull.reshape(1, -1))[0]).sum())
    if work * mean_stiffness(step) < YIELDING * float((pull**2).sum()):
        return ""
    return f"no film resists the forces: spheres roll around each other at once; {remedies(parameters)}"


def mean_stiffness(step: Step) -> float:
    """The mean of the diagonal (N/m), without glued spheres, whose glue is far stiffer."""
    glued = np.zeros(len(step.bodies.position), np.bool_)
    if step.walls:
        glued[step.walls.touches.first[step.walls.touches.glue > 0.0]] = not glued.all()
    blocks = step.matrix.blocks[step.matrix.pattern.diagonal[~glued]]
    return float(np.abs(np.trace(blocks, axis1=1, axis2=2)).mean() / blocks.shape[1])


def _softened(scratch: Workspace, columns: Array) -> Array:
    """The displacements of the spheres under the forces in `columns`, with the added stiffness."""
    from scipy.sparse import bsr_array, eye_array
    from scipy.sparse.linalg import spsolve

    matrix = scratch.step.matrix
    pattern, blocks = matrix.pattern, matrix.blocks
    whole = bsr_array((blocks, pattern.column, pattern.start)).tocsc()
    held = whole + HELD * mean_stiffness(scratch.step) * eye_array(whole.shape[0])
    width, bodies = blocks.shape[1], (-1, len(pattern.order), blocks.shape[1])
    ordered = columns.reshape(bodies)[:, pattern.order].reshape(len(columns), -1)
    found = np.array([spsolve(held.tocsc(), column) for column in ordered])
    return np.asarray(found.reshape(bodies)[:, pattern.rank].reshape(len(columns), width * len(pattern.order)))


def remedies(parameters: Parameters) -> str:
    """Suggestions that let a loose packing support a stress."""
    reach = with_prefix(parameters.contacts.fade_from, "m", 3)
    return f"set hydrodynamics.drag = 'stokes', a larger films.cutoff (now {reach}) or a larger cell.volume_fraction"


def unborne(parameters: Parameters, state: State, rules: Rules) -> str:
    """A message on a stress that no film carries, with remedies; empty if films percolate through the periodic cell."""
    stress = unjoined(parameters, state, rules)
    where = "around the cell" if stress == "pressure" else "around the cell from bottom to top"
    return f"no films lead {where}, so that nothing bears any {stress}; {remedies(parameters)}" if stress else ""


def unbalanced(parameters: Parameters, scratch: Workspace, at: tuple[Drive, Rules]) -> str:
    """A sentence on why there is no balance, with remedies."""
    drive, rules = at
    if not any(rules):
        pressed = "the surfaces cannot balance forces and wall stresses as large as these; reduce them"
        large = "the surfaces cannot balance forces as large as these; reduce them"
        return (
            without_deflection(parameters, scratch, at)
            or rolling(parameters, scratch, drive, drive.load)
            or (pressed if len(parameters.walls.free) else large)
        )
    cause = "the films bear a stress across the cell, but not as large a one; reduce it, have it grow from zero"
    return cause if parameters.drag.any() else f"{cause}, or {remedies(parameters)}"


def is_met(parameters: Parameters, state: State, wall: int) -> bool:
    """Whether a film connects a sphere that is not glued to a wall with the wall, or with a sphere that is glued to
    it.
    """
    glued = parameters.walls.glue[:, wall] > 0.0
    pair = state.pair[: state.contacts[0]]
    beside = glued[pair].sum(axis=1) == 1
    return bool(beside.any() or wall_films(parameters, state)[:, wall].any())


def unmet_wall(parameters: Parameters, state: State) -> str:
    """A sentence on a movable wall without films; empty if each movable wall has some."""
    for wall, axis in parameters.walls.free:
        if not is_met(parameters, state, wall) and parameters.walls.force[wall, axis] != 0.0:
            inward = parameters.walls.surfaces.place[wall]
            name = SIDE_NAMES[int(np.flatnonzero(inward)[0]), -float(inward.sum())]
            return f"no film holds the {name} wall against its stress; move it to the spheres with walls.position"
    return ""
