"""Effects of the keys of tracers."""

from . import FILES, OUTPUT, PICTURE, REFUSED, STOPS, grid, of

BASE = {
    "model": "tracers", "duration": 0.02, "frame_every": 0.02, "gravity": 9.81,
    "particles": [{"radius": 2e-4, "density": 2500.0, "count": 3}],
    "tank": {"high": [0.02, 0.016]}, "integration": {"time_step": 2e-3},
}  # fmt: skip
PLACED = {"particles": [{"count": None, "positions": [[0.005, 0.004], [0.008, 0.006]]}]}
SIZES = {"particles": [{"sizes": {"distribution": "normal", "mean": 1.9e-4, "spread": 0.1}}]}
HISTOGRAM = {
    "particles": [{"count": 2, "sizes": {"distribution": "histogram", "radii": [1.8e-4, 2e-4], "weights": [1.0, 1.0]}}]
}
SHARED = {"particles": [{"count": None, "volume_share": 0.5}, {"radius": 2e-4, "density": 2500.0, "count": 3}]}
FAST = {"particles": [{"velocity": [2.0, 0.5]}], "hydrodynamics": {"drag": "none"}}
OBSTACLE = {"obstacles": [{"low": [0.009, 0.0], "high": [0.011, 0.016]}], **FAST}
DISC = {"obstacles": [{"center": [0.01, 0.008], "radius": 0.004}], **FAST}
TRIANGLE = [[0.008, 0.0], [0.014, 0.002], [0.01, 0.016]]
OPENING = {"openings": [{"wall": 0, "low": [0.0, 0.0], "high": [0.0, 0.016]}]}
COMING = {"openings": [{**OPENING["openings"][0], "rate": 500.0, "velocity": [0.05, 0.0]}]}
CARRIED = {"openings": [{**OPENING["openings"][0], "concentration": 1e6}], "flow": {"velocity": [0.05, 0.0]}}
CHANNEL = {"flow": {"name": "channel", "speed": 0.02}}
CELLS = {"flow": {"name": "cellular", "speed": 0.02, "wavelength": 0.01, "center": [0.0, 0.0]}}
GYRE = {"flow": {"name": "double-gyre", "speed": 0.02, "swing": 0.2, "period": 0.1}}
ROTATION = {"flow": {"name": "rotation", "rate": 2.0}}
TUBE = {
    "tank": {"high": [0.02, 0.016, 0.016]},
    "flow": {"name": "tube", "speed": 0.02, "radius": 0.008, "center": [0.0, 0.008, 0.008]},
}
PULSE = {"flow": {"name": "channel", "speed": 0.02, "pulse": {"amplitude": 0.5, "period": 0.1}}}


AROUND = {
    "tank": None,
    "flow": {"velocity": [0.05, 0.0, 0.0], "around_obstacles": "ideal"},
    "obstacles": [{"center": [0.02, 0.0, 0.0], "radius": 0.01}],
    "particles": [{"count": None, "positions": [[0.005, 0.004, 0.0], [0.008, 0.006, 0.0]]}],
}
TURBULENT = {
    "flow": {"turbulence": {"heights": [0.0, 0.016], "diffusivities": [1e-6, 3e-6], "horizontal": 2e-6}},
    "integration": {"integrator": "overdamped"},
}
FORCED = {"flow": {"name": "channel", "speed": 0.2}, "integration": {"integrator": "inertial", "time_step": 1e-3}}
FIELD = {"flow": {"field": {"file": grid("one")}}}
STEERED = {"flow": {"field": {"file": grid("one"), "coordinates": ["x", "y"], "velocities": ["u", "v"]}}}
STICKING = {"particles": [{"velocity": [2.0, 0.5]}], "hydrodynamics": {"drag": "none"}}
WATER = {"liquid": {"name": "water"}}

DRIFT = {
    "user_laws": [{"law": "drift", "constants": [0.1]}],
    "particles": [{"name": "a"}, {"name": "b", "radius": 2e-4, "density": 2500.0, "count": 1}],
}
EVERY = {"output": {"samples": {"every": 4e-3}}}

EFFECTS = {
    **OUTPUT,
    "output.samples.every": of(8e-3, FILES, **EVERY),
    "user_laws.law": of("lift", **DRIFT),
    "user_laws.species": of(["b"], **DRIFT),
    "user_laws.constants": of([0.2], **DRIFT),
    "particles.velocities": of([[0.01, 0.0], [0.0, 0.02]], **PLACED),
    "model": of("sph", REFUSED),
    "title": of("another", PICTURE),
    "duration": of(0.04),
    "frame_every": of(0.01),
    "seed": of(1),
    "on_violation": of("stop", STOPS),
    "gravity": of(5.0),
    "liquid.name": of("glycerol", **WATER),
    "liquid.temperature": of(350.0, **WATER),
    "liquid.density": of(800.0),
    "liquid.viscosity": of(0.01),
    "liquid.mean_free_path": of(1e-4),
    "flow.velocity": of([0.01, 0.0]),
    "flow.shear_rate": of(1.0),
    "flow.around_obstacles": of("creeping", **AROUND),
    "flow.name": of("couette", **CHANNEL),
    "flow.speed": of(0.03, **CHANNEL),
    "flow.rate": of(3.0, **ROTATION),
    "flow.wavelength": of(0.02, **CELLS),
    "flow.period": of(0.05, **GYRE),
    "flow.swing": of(0.3, **GYRE),
    "flow.radius": of(0.01, **TUBE),
    "flow.center": of([0.002, 0.001], **CELLS),
    "flow.turbulence.heights": of([0.0, 0.008], **TURBULENT),
    "flow.turbulence.diffusivities": of([1e-5, 3e-5], **TURBULENT),
    "flow.turbulence.horizontal": of(1e-6, **TURBULENT),
    "flow.low": of([0.0, -0.01], **CHANNEL),
    "flow.high": of([0.02, 0.03], **CHANNEL),
    "flow.pulse.amplitude": of(0.9, **PULSE),
    "flow.pulse.period": of(0.2, **PULSE),
    "flow.pulse.decay_rate": of(10.0, **PULSE),
    "flow.field.file": of(grid("two", 2.0), **FIELD),
    "flow.field.length_unit": of(0.5, **FIELD),
    "flow.field.velocity_unit": of(0.5, **FIELD),
    "flow.field.time_unit": of(0.5, **FIELD),
    "flow.field.coordinates": of(["x", "other"], **STEERED),
    "flow.field.velocities": of(["u", "w"], **STEERED),
    "flow.field.time": of("tau", **FIELD),
    "flow.field.interpolation": of("linear", **FIELD),
    "flow.field.spacing": of(0.001, REFUSED, **FIELD),
    "particles.name": of("sand", PICTURE),
    "particles.count": of(4),
    "particles.radius": of(3e-4),
    "particles.radii": of([0.00018, 0.00019], **PLACED),
    "particles.sizes.distribution": of("uniform", **SIZES),
    "particles.sizes.mean": of(0.000194, **SIZES),
    "particles.sizes.spread": of(0.04, **SIZES),
    "particles.sizes.truncate": of(1.0, **SIZES),
    "particles.sizes.radii": of([0.00018, 0.000194], **HISTOGRAM),
    "particles.sizes.weights": of([1.0, 9.0], **HISTOGRAM),
    "particles.volume_share": of(0.3, **SHARED),
    "particles.density": of(3000.0),
    "particles.sphericity": of(0.5, hydrodynamics={"drag": "haider-levenspiel"}),
    "particles.positions": of([[0.005, 0.005], [0.008, 0.006]], **PLACED),
    "particles.low": of([0.01, 0.008], particles=[{"low": [0.005, 0.004], "high": [0.018, 0.014]}]),
    "particles.high": of([0.01, 0.014], particles=[{"low": [0.005, 0.004], "high": [0.018, 0.014]}]),
    "particles.velocity": of([0.01, 0.0]),
    "particles.color": of("orange", PICTURE),
    "tank.low": of([-0.005, 0.0]),
    "tank.high": of([0.03, 0.016]),
    "tank.radius": of(0.02, tank={"high": None, "radius": 0.01}),
    "tank.dimensions": of(3, tank={"high": None, "radius": 0.01}),
    "tank.vertices": of(
        [[0.0, 0.0], [0.02, 0.0], [0.01, 0.012]],
        tank={"high": None, "vertices": [[0.0, 0.0], [0.02, 0.0], [0.01, 0.01]]},
    ),
    "tank.restitution": of(0.5, **FAST),
    "tank.tangential_restitution": of(0.5, **FAST),
    "tank.sticking": of(True, **STICKING),
    "tank.periodic": of(["x"], **STICKING),
    "tank.walls.sticking": of(True, tank={"walls": [{"wall": 2}]}, **STICKING),
    "obstacles.sticking": of(True, **OBSTACLE),
    "tank.walls.wall": of(2, tank={"walls": [{"wall": 0, "restitution": 0.5}]}, **FAST),
    "tank.walls.restitution": of(0.2, tank={"walls": [{"wall": 2, "restitution": 0.5}]}, **FAST),
    "tank.walls.tangential_restitution": of(0.2, tank={"walls": [{"wall": 2}]}, **FAST),
    "obstacles.restitution": of(0.5, **OBSTACLE),
    "obstacles.tangential_restitution": of(0.5, **OBSTACLE),
    "obstacles.low": of([0.008, 0.0], **OBSTACLE),
    "obstacles.high": of([0.012, 0.016], **OBSTACLE),
    "obstacles.center": of([0.012, 0.008], **DISC),
    "obstacles.radius": of(0.003, **DISC),
    "obstacles.vertices": of([[0.007, 0.0], [0.014, 0.002], [0.01, 0.016]], obstacles=[{"vertices": TRIANGLE}], **FAST),
    "openings.wall": of(1, openings=[{**OPENING["openings"][0], "high": [0.02, 0.016]}], **FAST),
    "openings.low": of([0.0, 0.015], **OPENING, **FAST),
    "openings.high": of([0.0, 0.001], **OPENING, **FAST),
    "openings.rate": of(1000.0, **COMING),
    "openings.concentration": of(2e6, **CARRIED),
    "openings.species": of("b", particles=[{"name": "a"}, {"name": "b", "radius": 1e-4, "density": 2000.0}], **COMING),
    "openings.velocity": of([0.1, 0.0], **COMING),
    "hydrodynamics.drag": of("stokes"),
    "hydrodynamics.added_mass": of(False),
    "hydrodynamics.fluid_acceleration": of(
        True, flow={"name": "stagnation", "rate": 5.0}, integration={"integrator": "inertial", "time_step": 1e-3}
    ),
    "hydrodynamics.faxen": of(True, **FORCED),
    "hydrodynamics.lift": of(True, **FORCED),
    "hydrodynamics.wall_drag": of(True),
    "hydrodynamics.brownian": of(True),
    "integration.integrator": of("overdamped", integration={"time_step": 2e-3, "integrator": "inertial"}),
    "integration.time_step": of(1e-3),
}
