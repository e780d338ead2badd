"""One tank on many ranks: each rank has the neighbor lists and sums of a part of the liquid; all else is replicated.

Each rank has the whole state. Particles are in cell order, so that a part is a region of the tank; the rates of all
parts are gathered, so that all ranks continue with the same numbers: the bits are the same for any number of ranks, and
without MPI. See `ecume.models.floating.mpi`.
"""

from __future__ import annotations

from ecume.engine.mpi_exchange import Share
from ecume.errors import BadInput
from ecume.models.sph.integration.time_stepping import advance
from ecume.models.sph.parameters import Parameters
from ecume.models.sph.record import workspace
from ecume.models.sph.report.energy_budget import forces_work
from ecume.models.sph.state import State, Workspace


def require_spreadable(parameters: Parameters) -> None:
    """Raise BadInput for tanks that are not spread over ranks."""
    solid = parameters.boundary.dummies.position.shape[1] > 0
    if solid or forces_work(parameters):
        raise BadInput(
            "--engine mpi: goes with tanks whose sides are mirrors or periodic and stand still, and without solids, "
            "in- and outflows"
        )
    if parameters.pressure_force.transported or parameters.density_diffusion.gradients or parameters.transports:
        raise BadInput(
            "--engine mpi: does not support transport velocity, shifting, and density diffusion with gradients"
        )
    if parameters.projection is not None:
        raise BadInput("--engine mpi: does not support incompressible liquids: each iteration would exchange all sums")
    if parameters.tension != "none" or parameters.turbulence or parameters.passive_tracers.start[-1]:
        raise BadInput("--engine mpi: does not support surface tension, turbulence, and passive tracers")


def own_part(share: Share, parameters: Parameters, state: State) -> Parameters:
    """The parameters with the range of particles whose sums this rank computes."""
    first, last = share.parts(state.position.shape[1])[share.rank : share.rank + 2]
    constants = parameters.constants.copy()
    constants[0].first, constants[0].last = first, last
    return parameters._replace(constants=constants)


def workspace_shared(share: Share, parameters: Parameters, state: State, room: float) -> Workspace:
    """See `ecume.models.model.Model.workspace`: lists of the own part."""
    made = workspace(own_part(share, parameters, state), state, room)
    made.share = share
    return made


def integrate_shared(share: Share, parameters: Parameters, state: State, workspace: Workspace, steps: int) -> int:
    """Integrate: see `ecume.models.model.Model.advance`."""
    return advance(own_part(share, parameters, state), state, workspace, steps)


def complete(share: Share, parameters: Parameters, state: State, scratch: Workspace) -> Workspace:
    """A workspace with the lists of all particles, for sums that one rank takes alone."""
    return workspace(parameters, state, 1.0)
