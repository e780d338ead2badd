"""Effects of the keys of floats."""

from . import FILES, OUTPUT, PICTURE, REFUSED, STOPS, grid, merged, of

BASE = {
    "model": "floating", "duration": 5e-4, "frame_every": 5e-4,
    "particles": [{"radius": 1e-3, "density": 600.0, "contact_angle": 1.2,
                   "positions": [[0.0, 0.0], [2.6e-3, 2e-4], [-4e-4, 2.7e-3]]}],
    "integration": {"time_step": 5e-5},
}  # fmt: skip
WATER = {"liquid": {"name": "water"}}
WARM = {"liquid": {"name": "water"}}
NODES = {
    "low": [-0.01, -0.01],
    "high": [0.01, 0.01],
    "vx": [[0.0, 0.0], [0.01, 0.01]],
    "vy": [[0.0, 0.01], [0.0, 0.01]],
}
FIELD = {"flow": {"field": {"file": grid("one")}}}
STEERED = {"flow": {"field": {"file": grid("one"), "coordinates": ["x", "y"], "velocities": ["u", "v"]}}}
NOISE = {"hydrodynamics": {"brownian": True}, "integration": {"integrator": "overdamped", "time_step": 5e-5}}
SCATTERED = {"particles": [{"positions": None, "count": 4}], "dish": {"radius": 0.02}}
DISC = {"particles": [{"contact_angle": None, "disc": {"thickness": 1e-3}}]}
MULTIPOLE = {"interaction": {"method": "multipole", "order": 2}}
UNDULATED = {
    "particles": [{"contact_angle": None, "disc": {"thickness": 1e-3, "undulation": 1e-5, "angle": 0.3}}],
    **MULTIPOLE,
}
STAR = {
    "particles": [{"contact_angle": None, "shape": {"kind": "star", "width": 4e-4, "thickness": 3e-4, "angle": 0.2}}]
}
SQUARE = {"particles": [{"contact_angle": None, "shape": {"kind": "square", "angle": 0.2}}]}
ELLIPSOID = {"particles": [{"shape": {"kind": "ellipsoid", "width": 1.2e-3, "angle": 0.3}}]}
ENERGIES = {"particles": [{"contact_angle": None, "surface_energies": {"solid_gas": 0.03, "solid_liquid": 0.02}}]}
ROW = {"rows": [{"x": 6e-3, "y": 0.0, "radius": 1e-3, "density": 600.0, "contact_angle": 1.2}]}
TURNING_ROW = {"rows": [{"x": 6e-3, "y": 0.0, "radius": 1e-3, "density": 600.0, "contact_angle": 1.2,
                         "shape": {"kind": "ellipsoid", "width": 1.2e-3}}]}  # fmt: skip
DISH = {"dish": {"radius": 0.01, "contact_angle": 1.0}}
ANNULUS = {
    "particles": [{"positions": [[5e-3, 0.0], [0.0, 5e-3], [-5e-3, 0.0]]}],
    "dish": {"radius": 0.01, "contact_angle": 1.0, "inner_radius": 1e-3, "inner_contact_angle": 1.0},
}
TILTED = {"dish": {"radius": 0.01, "tilt": {"angle": 0.1, "direction": 0.2}}}
SHARED = {
    "particles": [
        {"positions": None, "volume_share": 0.5},
        {"radius": 1e-3, "density": 600.0, "contact_angle": 1.2, "count": 3},
    ],
    "dish": {"radius": 0.02},
}
SIZES = {"particles": [{"sizes": {"distribution": "normal", "mean": 1e-3, "spread": 0.1}}]}
HISTOGRAM = {"particles": [{"sizes": {"distribution": "histogram", "radii": [9e-4, 1e-3], "weights": [1.0, 1.0]}}]}
IMPACT = {"particles": [{"velocities": [[0.0, 0.0], [-20.0, 0.5], [0.0, 0.0]]}]}
IMPACTS = {"particles": [{"velocities": [[0.0, 0.0], [-20.0, 0.5], [2.0, -20.0]]}]}
WALL_IMPACT = {"particles": [{"velocity": [20.0, 2.0]}], "hydrodynamics": {"drag": "stokes"}, **DISH}
MOVED = {"dish": {"radius": 0.01, "contact_angle": 1.0, "motion": {"amplitude": 1e-3, "frequency": 2.0}}}
BARRIER = {"dish": {"size": [0.02, 0.02], "law": "none", "barrier": {"velocity": 0.1, "start": 6.4e-3}}}
STROKE = {
    "dish": {
        "size": [0.02, 0.02],
        "law": "none",
        "barrier": {"times": [0.0, 2e-4, 6e-4], "positions": [0.0, 1e-4, 3e-4]},
    }
}
SWEPT = {
    "dish": {"size": [0.02, 0.02], "law": "none", "barrier": {"velocity": 20.0, "stop": 9e-3}},
    "integration": {"time_step": None},
}
FILMS = {
    "hydrodynamics": {"lubrication": {"roughness": 1e-6}},
    "integration": {"integrator": "overdamped", "time_step": 5e-5},
}
ACTIVE = {"activity": {"force": 1e-8, "persistence": 1e-3, "propulsion": 1e-8}}
SOURCE = {"place": [5e-4, 0.0], "force": 1e-4, "phase": 0.2}
RADIATED = {"waves": {"frequency": 100.0, "headings": [0.0, 1.0, 2.0], "sources": [SOURCE, {"force": 1e-4}]}}
MAGNETIZED = {
    "magnetic_field": {
        "constant": [1e-3, 2e-3, 4e-3], "amplitude": [2e-3, 1e-3, 0.0], "frequency": 200.0, "susceptibility": 5.0,
    }
}  # fmt: skip
SPRINGS = {"contacts": {"law": "spring-dashpot", "stiffness": 1.0}, "integration": {"time_step": None}, **IMPACT}
RING = {"particles": [{"positions": None, "count": 3, "placement": "ring", "ring_radius": 5e-3}]}
LATTICE = {"particles": [{"positions": None, "count": 3, "placement": "lattice", "spacing": 3e-3}]}

CELL = {"cell": {"size": [0.08, 0.08]}, "particles": [{"velocity": [-1.0, 0.0]}]}
EVERY = {"output": {"samples": {"every": 1e-4}}}
TWO = {"particles": [{"name": "a"}, {"name": "b", "radius": 1e-3, "density": 600.0, "contact_angle": 1.2,
                                     "positions": [[8e-3, 0.0]]}]}  # fmt: skip
SOAP = {
    "surfactant": {
        "diffusivity": 1e-4, "tension_slope": 10.0, "loss_rate": 1.0, "spacing": 1e-3, "largest_fall": 0.02,
        "sources": [{"release": 1e-6}], "drops": [{"position": [0.0, 3e-3], "radius": 2e-3, "mass": 1e-7}],
    },
    "dish": {"radius": 0.012}, "integration": {"time_step": 1e-5},
}  # fmt: skip
CARRIED = {**SOAP, "flow": {"velocity": [0.2, 0.0]}}
SOAPED = {**SOAP, **TWO}
PUSH = {"user_laws": [{"law": "push", "constants": [1e-9]}], **TWO}

EFFECTS = {
    **OUTPUT,
    "output.samples.every": of(2e-4, FILES, **EVERY),
    "user_laws.law": of("hold", **PUSH),
    "user_laws.species": of(["a", "b"], **PUSH),
    "user_laws.constants": of([2e-9], **PUSH),
    "cell.size": of([0.09, 0.08], **CELL),
    "cell.area_fraction": of(1e-3, **CELL),
    "liquid.color": of("orange", PICTURE),
    "model": of("tracers", REFUSED),
    "title": of("another", PICTURE),
    "duration": of(1e-3),
    "frame_every": of(2.5e-4),
    "seed": of(1, **SCATTERED),
    "on_violation": of("stop", STOPS),
    "theory": of("linear"),
    "gravity": of(5.0),
    "liquid.name": of("glycerol", **WATER),
    "liquid.temperature": of(350.0, **WARM),
    "liquid.density": of(1100.0),
    "liquid.viscosity": of(0.01),
    "liquid.surface_tension": of(0.05),
    "liquid.gas_density": of(1.2),
    "liquid.gas_viscosity": of(1e-4),
    "flow.velocity": of([0.01, 0.0], flow={"shear_rate": 0.1}),
    "flow.shear_rate": of(1.0, flow={"velocity": [0.01, 0.0]}),
    "flow.rotation_rate": of(1.0, flow={"velocity": [0.01, 0.0]}),
    "flow.extension_rate": of(1.0, flow={"velocity": [0.01, 0.0]}),
    "flow.nodes.low": of([-0.02, -0.01], flow={"nodes": NODES}),
    "flow.nodes.high": of([0.02, 0.01], flow={"nodes": NODES}),
    "flow.nodes.vx": of([[0.0, 0.0], [0.02, 0.02]], flow={"nodes": NODES}),
    "flow.nodes.vy": of([[0.0, 0.02], [0.0, 0.02]], flow={"nodes": NODES}),
    "flow.field.file": of(grid("two", 2.0), **FIELD),
    "flow.field.length_unit": of(0.5, **FIELD),
    "flow.field.velocity_unit": of(0.5, **FIELD),
    "flow.field.time_unit": of(1e-3, **FIELD),
    "flow.field.coordinates": of(["x", "other"], **STEERED),
    "flow.field.velocities": of(["u", "w"], **STEERED),
    "flow.field.time": of("tau", **FIELD),
    "flow.field.interpolation": of("linear", **FIELD),
    "flow.field.spacing": of(0.001, REFUSED, **FIELD),
    "particles.name": of("cereal", PICTURE),
    "particles.count": of(5, **SCATTERED),
    "particles.radius": of(9e-4),
    "particles.density": of(500.0),
    "particles.contact_angle": of(1.0),
    "particles.placement": of("lattice", REFUSED, **RING),
    "particles.radii": of([9e-4, 9.5e-4, 1e-3]),
    "particles.sizes.distribution": of("uniform", **SIZES),
    "particles.sizes.mean": of(9.7e-4, **SIZES),
    "particles.sizes.spread": of(0.04, **SIZES),
    "particles.sizes.truncate": of(1.0, **SIZES),
    "particles.sizes.radii": of([9e-4, 9.7e-4], **HISTOGRAM),
    "particles.sizes.weights": of([1.0, 9.0], **HISTOGRAM),
    "particles.volume_share": of(0.3, **SHARED),
    "particles.positions": of([[0.0, 0.0], [2.7e-3, 2e-4], [-4e-4, 2.7e-3]]),
    "particles.velocity": of([0.01, 0.0]),
    "particles.velocities": of([[0.0, 0.0], [0.01, 0.0], [0.0, 0.0]]),
    "particles.spacing": of(4e-3, **LATTICE),
    "particles.ring_radius": of(6e-3, **RING),
    "particles.center": of([1e-3, 0.0], **RING),
    "particles.magnetic_moment": of(1e-6),
    "particles.color": of("orange", PICTURE),
    "particles.surface_energies.solid_gas": of(0.04, **ENERGIES),
    "particles.surface_energies.solid_liquid": of(0.01, **ENERGIES),
    "particles.disc.thickness": of(1.2e-3, **DISC),
    "particles.disc.rim": of(
        "top", particles=[{"contact_angle": None, "density": 1500.0, "disc": {"thickness": 3e-4}}]
    ),
    "particles.disc.tilting": of(False, **{**DISC, **MULTIPOLE}),
    "particles.disc.tension_moment": of(True, **{**DISC, **MULTIPOLE}),
    "particles.disc.undulation": of(2e-5, **UNDULATED),
    "particles.disc.mode": of(3, **{**UNDULATED, "interaction": {"method": "multipole", "order": 3}}),
    "particles.disc.angle": of(0.5, **UNDULATED),
    "particles.shape.kind": of("needle", **ELLIPSOID),
    "particles.shape.width": of(1.0e-3, **ELLIPSOID),
    "particles.shape.thickness": of(4e-4, **STAR),
    "particles.shape.arms": of(6, **STAR),
    "particles.shape.corner": of(0.5, **SQUARE),
    "particles.shape.rim": of("top", **STAR),
    "particles.shape.undulation": of(1e-5, **STAR),
    "particles.shape.mode": of(
        3, particles=[{"shape": {"kind": "ellipsoid", "width": 1.2e-3, "angle": 0.3, "undulation": 1e-5}}]
    ),
    "particles.shape.angle": of(0.5, **ELLIPSOID),
    "rows.x": of(7e-3, **ROW),
    "rows.y": of(1e-3, **ROW),
    "rows.vx": of(0.01, **ROW),
    "rows.vy": of(0.01, **ROW),
    "rows.radius": of(9e-4, **ROW),
    "rows.density": of(500.0, **ROW),
    "rows.contact_angle": of(1.0, **ROW),
    "rows.magnetic_moment": of(1e-6, particles=[{"magnetic_moment": 1e-6}], **ROW),
    "rows.angle": of(0.5, **TURNING_ROW),
    "rows.spin": of(5.0, **TURNING_ROW),
    "rows.species_name": of("pearl", PICTURE, **ROW),
    "rows.color": of("orange", PICTURE, rows=[{**ROW["rows"][0], "species_name": "pearl"}]),
    "dish.shape": of("round", REFUSED, dish={"size": [0.02, 0.02]}),
    "dish.radius": of(0.012, **DISH),
    "dish.vertices": of(
        [[-9e-3, -9e-3], [9e-3, -9e-3], [0.0, 9e-3]], REFUSED, dish={"size": [0.02, 0.02], "law": "none"}
    ),
    "dish.size": of([0.02, 0.03], dish={"size": [0.02, 0.02], "contact_angle": 1.0}),
    "dish.contact_angle": of(1.3, **DISH),
    "dish.inner_radius": of(1.5e-3, **ANNULUS),
    "dish.inner_contact_angle": of(1.3, **ANNULUS),
    "dish.tilt.angle": of(0.2, **TILTED),
    "dish.tilt.direction": of(0.7, **TILTED),
    "dish.law": of("linear", **DISH),
    "dish.image": of("pinned", **DISH),
    "dish.density": of(2000.0, dish={"radius": 0.01, "law": "two-point-legacy"}),
    "dish.restitution": of(0.9, **WALL_IMPACT),
    "dish.friction": of(0.5, **WALL_IMPACT),
    "dish.rolling_friction": of(0.5, **merged(WALL_IMPACT, {"dish": {"friction": 0.5}})),
    "dish.barrier.side": of("left", **BARRIER),
    "dish.barrier.both": of(True, **BARRIER),
    "dish.barrier.velocity": of(0.2, **BARRIER),
    "dish.barrier.start": of(6.3e-3, **BARRIER),
    "dish.barrier.stop": of(6.42e-3, **BARRIER),
    "dish.barrier.times": of([0.0, 3e-4, 6e-4], **STROKE),
    "dish.barrier.positions": of([0.0, 2e-4, 3e-4], **STROKE),
    "dish.barrier.largest_pressure": of(1e3, **SWEPT),
    "dish.motion.velocity": of([0.01, 0.0], **MOVED),
    "dish.motion.amplitude": of(2e-3, **MOVED),
    "dish.motion.direction": of(0.5, **MOVED),
    "dish.motion.frequency": of(3.0, **MOVED),
    "dish.motion.entrainment": of(0.5, **MOVED),
    "integration.integrator": of("rk4"),
    "integration.time_step": of(2.5e-5),
    "hydrodynamics.drag": of("none"),
    "hydrodynamics.added_mass": of(True),
    "hydrodynamics.brownian": of(True, integration=NOISE["integration"]),
    "hydrodynamics.interaction": of("rotne-prager", liquid={"viscosity": 1.0}, integration=NOISE["integration"]),
    "hydrodynamics.lubrication.roughness": of(1e-5, **FILMS),
    "hydrodynamics.lubrication.cutoff": of(2.5, **FILMS),
    "surfactant.diffusivity": of(2e-4, **SOAP),
    "surfactant.tension_slope": of(20.0, **SOAP),
    "surfactant.loss_rate": of(100.0, **SOAP),
    "surfactant.largest_fall": of(0.001, **SOAP),
    "surfactant.advected": of(False, **CARRIED),
    "surfactant.spacing": of(0.8e-3, **SOAP),
    "surfactant.sources.species": of("a", **SOAPED),
    "surfactant.sources.release": of(2e-6, **SOAP),
    "surfactant.drops.position": of([1e-3, 3e-3], **SOAP),
    "surfactant.drops.radius": of(3e-3, **SOAP),
    "surfactant.drops.mass": of(2e-7, **SOAP),
    "activity.force": of(2e-8, **ACTIVE),
    "activity.persistence": of(2e-3, **ACTIVE),
    "activity.propulsion": of(2e-8, **ACTIVE),
    "activity.rotational_diffusion": of(100.0, **ACTIVE),
    "activity.torque": of(1e-9, **ACTIVE),
    "activity.species": of(
        ["passive"],
        particles=[
            {"name": "swimmer"},
            {"name": "passive", "radius": 1e-3, "density": 600.0, "contact_angle": 1.2, "positions": [[8e-3, 0.0]]},
        ],
        activity=ACTIVE["activity"] | {"species": ["swimmer"]},
    ),
    "magnetic_field.constant": of([2e-3, 2e-3, 4e-3], **MAGNETIZED),
    "magnetic_field.amplitude": of([2e-3, 2e-3, 0.0], **MAGNETIZED),
    "magnetic_field.frequency": of(300.0, **MAGNETIZED),
    "magnetic_field.phase": of([0.5, 0.0, 0.0], **MAGNETIZED),
    "magnetic_field.susceptibility": of(6.0, **MAGNETIZED),
    "magnetic_field.species": of(
        ["plastic"],
        particles=[
            {"name": "steel"},
            {"name": "plastic", "radius": 1e-3, "density": 600.0, "contact_angle": 1.2, "positions": [[8e-3, 0.0]]},
        ],
        magnetic_field=MAGNETIZED["magnetic_field"] | {"species": ["steel"]},
    ),
    "waves.frequency": of(140.0, **RADIATED),
    "waves.headings": of([0.0, 1.0, 3.0], **RADIATED),
    "waves.sources.place": of([0.0, 5e-4], **RADIATED),
    "waves.sources.force": of(2e-4, **RADIATED),
    "waves.sources.phase": of(1.0, **RADIATED),
    "waves.sources.species": of(
        "still",
        particles=[
            {"name": "oscillating"},
            {"name": "still", "radius": 1e-3, "density": 600.0, "contact_angle": 1.2, "positions": [[8e-3, 0.0]]},
        ],
        waves={"frequency": 100.0, "headings": [0.0, 1.0, 2.0, 0.0], "sources": [SOURCE, {"force": 1e-4}]},
    ),
    "contacts.restitution": of(0.9, **IMPACT),
    "contacts.friction": of(0.5, **IMPACT),
    "contacts.rolling_friction": of(0.5, contacts={"friction": 0.5}, **IMPACTS),
    "contacts.legacy_coefficient": of(0.8, **IMPACT),
    "contacts.law": of("none", **IMPACT),
    "contacts.stiffness": of(2.0, **SPRINGS),
    "interaction.law": of("none"),
    "interaction.constants": of([1.0], REFUSED),
    "interaction.charge": of("linear"),
    "interaction.method": of("multipole", interaction={"order": 2}),
    "interaction.order": of(3, **MULTIPOLE),
    "interaction.accuracy": of(1e-2),
    "interaction.summation": of("grid"),
    "interaction.precision": of("single"),
}
