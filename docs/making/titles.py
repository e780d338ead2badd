"""The titles of pages on Python modules: concepts instead of names of modules."""

from __future__ import annotations

import re
import types

CLAUSE = re.compile(r"^(what|how|where|who|whom|which|whether|why|when|whose|from)\b", re.IGNORECASE)
LONGEST = 6
"""Words of a title."""
TITLES = {
    "run.reports": "Information about runs",
    "run.checkpoints": "Checkpoints",
    "run.lock": "Run lock",
    "run.recording": "Recording of frames",
    "run.runner": "Run control",
    "run.user_code": "User laws and actions",
    "trajectories.frame": "Frames",
    "trajectories.reader": "Trajectories",
    "trajectories.exports": "Exports",
    "sweep.figures": "Figures of a sweep",
    "sweep.executors": "Executors and workers",
    "citing": "References of a scene",
    "errors": "Errors",
    "units": "Units",
    "fitting.parameters": "Fitted parameters",
    "fitting.estimation": "Estimation of parameters",
    "laws.arguments": "Argument checks",
    "laws.surfaces": "Surfaces of contacts",
    "laws.capillarity": "Capillary forces",
    "laws.states": "Equations of state",
    "laws.brownian_motion": "Brownian motion",
    "laws.density_diffusion": "Diffusion of density",
    "laws.drag": "Viscous drag",
    "laws.flows": "Exact flows",
    "laws.drops": "Drops",
    "laws.hydrostatics": "Hydrostatics",
    "laws.moving_dish": "Moving dish",
    "laws.soft_contacts": "Tension and shear of contacts",
    "laws.water_waves": "Waves and sloshing",
    "laws.soft_pair": "Two soft spheres",
    "laws.contact_lines": "Noncircular contact lines",
    "laws.ewald": "Ewald splitting",
    "laws.flotation.balance": "Vertical force balance",
    "laws.flotation.bodies": "Floating bodies, dimensionless numbers",
    "laws.flotation.nonspherical": "Floating discs, cylinders, ellipsoids, bubbles",
    "laws.flotation.equilibria": "Equilibrium and attraction of floating bodies",
    "laws.flotation.young_laplace": "Young–Laplace equation",
    "laws.friction": "Collisions, friction of rough surfaces",
    "laws.meniscus": "Menisci at walls",
    "laws.interfaces": "Mobility of interfaces",
    "laws.kernels": "Smoothing kernels",
    "laws.liquids": "Liquids by name",
    "laws.long_range": "Long-range forces",
    "laws.multipole.closures": "Multipole response of a body",
    "laws.multipole.solving": "Multipole equations",
    "laws.multipole.many": "Multipole solver",
    "laws.pair_laws": "Pair laws, magnetic dipoles",
    "laws.special": "Bessel functions",
    "laws.tension": "Surface tension between particles",
    "laws.time_step_limits": "Time step limits",
    "laws.viscous": "Viscous forces",
    "laws.wall_forces": "Walls and particles of a liquid",
    "analysis.gauges": "Gauges of liquids",
    "analysis.free_surface": "Free surface",
    "analysis.close_pairs": "Close pairs and contacts",
    "analysis.grids": "Fields on grids and lines",
    "analysis.rearrangements": "Rearrangements",
    "analysis.series": "Time series",
    "analysis.structure": "Arrangement and paths",
    "engine.walls.sheets": "Surfaces in compiled loops",
    "engine.walls.surfaces": "Reflecting surfaces and openings",
    "engine.walls.event_driven": "Event-driven motion",
    "engine.walls.reflecting": "Reflection",
    "models.model": "Model interface",
    "models.soft.contacts.contact": "Single contact",
    "models.soft.contacts.contact_list": "Contact list",
    "models.soft.contacts.tree_search": "Neighbors of few spheres",
    "models.soft.contacts.films": "Film forces",
    "models.soft.contacts.rotation": "Rotation of spheres",
    "models.soft.contacts.walls": "Plane walls",
    "models.soft.integration.bordered_system": "Bordered linear system",
    "models.soft.integration.dirk": "Implicit Runge–Kutta steps",
    "models.soft.integration.dirk_schemes": "Implicit Runge–Kutta schemes",
    "models.soft.integration.linear_solvers": "Choice of the linear solver",
    "models.soft.integration.newton": "Newton's method",
    "models.soft.integration.time_stepping": "Adaptive time integration",
    "models.soft.cell": "Periodic box",
    "models.soft.protocol": "Loading protocol",
    "models.soft.parameters": "Parameters",
    "models.soft.record": "Soft model",
    "models.soft.report.check_report": "Rows of check",
    "models.soft.report.observation": "Observation",
    "models.soft.setup": "Setup",
    "models.soft.state": "State",
    "models.soft.t1.cluster": "Cluster of four spheres",
    "models.soft.t1.paper_scheme": "Scheme of the paper",
    "models.soft.t1.process": "T1 process",
    "show.figures": "Figures",
    "show.movies": "Movies",
    "show.view.page": "Interactive page",
    "show.style": "Picture style",
}
"""By module. Others have the beginning of their docstring, up to the first colon, if that is short."""


def title_of(module: types.ModuleType) -> str:
    """The title of a module's page."""
    name = module.__name__.removeprefix("ecume.")
    if name in TITLES:
        return TITLES[name]
    head = re.split(r"[:.;]", " ".join((module.__doc__ or "").split()), maxsplit=1)[0]
    short = head and len(head.split()) <= LONGEST and not CLAUSE.match(head) and "`" not in head
    return head if short else name.rpartition(".")[2].replace("_", " ").capitalize()
