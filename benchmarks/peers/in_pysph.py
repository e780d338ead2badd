"""PySPH: its weakly compressible equations without XSPH, which the other packages lack, with OpenMP.

OMP_NUM_THREADS=THREADS python in_pysph.py EDGE STEPS THREADS
"""

from __future__ import annotations

import os
import sys
import tempfile

import cube

edge, steps, threads = cube.asked()
sys.argv = sys.argv[:1]
os.environ["OMP_NUM_THREADS"] = str(threads)

from compyle.config import get_config  # noqa: E402
from pysph.base.kernels import CubicSpline  # noqa: E402
from pysph.base.nnps import LinkedListNNPS  # noqa: E402
from pysph.base.utils import get_particle_array_wcsph  # noqa: E402
from pysph.solver.solver import Solver  # noqa: E402
from pysph.sph.basic_equations import ContinuityEquation  # noqa: E402
from pysph.sph.equation import Equation, Group  # noqa: E402
from pysph.sph.integrator import PECIntegrator  # noqa: E402
from pysph.sph.integrator_step import WCSPHStep  # noqa: E402
from pysph.sph.wc.basic import MomentumEquation, TaitEOS  # noqa: E402

WARM_UP = 3


class Drift(Equation):
    """The velocity that moves a particle is its own: what XSPH would alter."""

    def initialize(self, d_idx, d_ax, d_ay, d_az, d_u, d_v, d_w):
        d_ax[d_idx] = d_u[d_idx]
        d_ay[d_idx] = d_v[d_idx]
        d_az[d_idx] = d_w[d_idx]


def main() -> None:
    """Time so many steps."""
    get_config().use_openmp = True
    water = cube.cube(edge)
    x, v = water.position.T.copy(), water.velocity.T.copy()
    fluid = get_particle_array_wcsph(
        name="fluid", x=x[0], y=x[1], z=x[2], u=v[0], v=v[1], w=v[2],
        m=water.mass, h=0.5 * water.support, rho=cube.DENSITY,
    )  # fmt: skip
    state = TaitEOS(dest="fluid", sources=None, rho0=cube.DENSITY, c0=cube.SOUND, gamma=cube.STIFFENING)
    momentum = MomentumEquation(dest="fluid", sources=["fluid"], c0=cube.SOUND, alpha=cube.ALPHA, beta=0.0)
    rates = [ContinuityEquation(dest="fluid", sources=["fluid"]), momentum, Drift(dest="fluid", sources=["fluid"])]
    solver = Solver(
        kernel=CubicSpline(dim=3), dim=3, integrator=PECIntegrator(fluid=WCSPHStep()), dt=cube.TIME_STEP,
        tf=(WARM_UP + steps + 0.5) * cube.TIME_STEP, adaptive_timestep=False, pfreq=10**9,
    )  # fmt: skip
    solver.set_parallel_manager(None)
    solver.set_disable_output(True)
    nnps = LinkedListNNPS(dim=3, particles=[fluid], radius_scale=2.0, cache=False)
    solver.setup(particles=[fluid], equations=[Group([state], real=False), Group(rates)], nnps=nnps, kernel=None)
    solver.set_output_directory(tempfile.mkdtemp())
    watches: list[cube.Watch] = []
    solver.add_post_step_callback(lambda _: watches.append(cube.Watch()))
    solver.solve(show_progress=False)
    watches[WARM_UP - 1].report(len(watches) - WARM_UP, water.count)


main()
