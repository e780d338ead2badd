"""Effects of the keys of soft spheres."""

from . import FILES, OUTPUT, PICTURE, REFUSED, STOPS, merged, of

BASE = {
    "model": "soft", "duration": 1e-3, "frame_every": 1e-3,
    "liquid": {"viscosity": 1e-3},
    "particles": [
        {"radius": 1.0, "modulus": 1.0, "positions": [[0.0, 1.05], [2.05, 1.07]], "force": [2e-3, 1e-5]},
        {"radius": 0.98, "modulus": 1.3, "positions": [[1.0, 2.86], [3.05, 2.88]], "force": [-2e-3, -1e-5]},
    ],
    "cell": {"size": [4.1, 3.93]}, "integration": {"tolerance": 1e-2},
}  # fmt: skip
WATER = {"liquid": {"name": "water", "viscosity": None}}
HEAVY = {"liquid": {"density": 1.0}, "particles": [{"density": 1.1}, {"density": 1.1}]}
FALLING = {**HEAVY, "gravity": 1e-3, "walls": [{"side": "bottom"}]}
BUBBLES = {"films": {"surface": "bubble"}, "liquid": {"surface_tension": 1.0}}
COULOMB = {
    "films": {"friction": "coulomb", "roughness": 0.08},
    "rotation": True,
    "protocol": [{"time": 0.0, "shear_rate": 0.05}],
}
SHEAR = {"protocol": [{"time": 0.0, "shear_rate": 0.05}]}
STERIC = {"long_range_forces": {"law": "steric", "steric_strength": 1e-3, "steric_length": 0.08}}
DLVO = {
    "long_range_forces": {"law": "dlvo", "hamaker_constant": 1e-6, "double_layer_strength": 1e-4, "debye_length": 0.05}
}
PUSH = {"user_laws": [{"law": "push", "species": ["sphere-1", "sphere-2"], "constants": [1e-6]}]}
WALLS = {"walls": [{"side": "bottom"}, {"side": "top"}]}
PERMEATED = {
    "walls": [{"side": "bottom", "drained": False}, {"side": "top", "drained": True, "pressure": 1e-3}],
    "permeation": {"law": "constant", "permeability": 1e-3, "layer_height": 2.0},
}
LOOSE = {"positions": None, "force": None, "count": 4}
SCATTERED = {"particles": [LOOSE, LOOSE], "cell": {"size": [6.5, 6.5]}, **SHEAR}

SHARED = {"particles": [{**LOOSE, "count": None, "volume_share": 0.5}, LOOSE], "cell": {"size": [6.5, 6.5]}, **SHEAR}
SIZES = {"particles": [{"sizes": {"distribution": "normal", "mean": 0.98, "spread": 0.02}}]}
HISTOGRAM = {"particles": [{"sizes": {"distribution": "histogram", "radii": [0.9, 0.98], "weights": [1.0, 1.0]}}]}

PREPARED = {**SCATTERED, "preparation": {"volume_fraction": 0.65, "rate": 20.0, "relaxed": 0.5}}

SAMPLES = {"output": {"samples": {"every": 2e-4, "block": 2, "numbers": ["elastic_energy"]}}}

EFFECTS = {
    **OUTPUT,
    "output.samples.every": of(1e-3, FILES, **SAMPLES),
    "output.samples.every_steps": of(3, FILES),
    "output.samples.block": of(1, FILES, **SAMPLES),
    "output.samples.numbers": of([], FILES, **SAMPLES),
    "user_laws.law": of("hold", **PUSH),
    "user_laws.species": of(["sphere-1", "sphere-1"], **PUSH),
    "user_laws.constants": of([2e-6], **PUSH),
    "model": of("tracers", REFUSED),
    "title": of("another", PICTURE),
    "duration": of(2e-3),
    "frame_every": of(5e-4),
    "seed": of(1, **SCATTERED),
    "on_violation": of("stop", STOPS),
    "rotation": of(True, **SHEAR),
    "gravity": of(2e-3, **FALLING),
    "liquid.name": of("glycerol", **WATER),
    "liquid.temperature": of(350.0, **WATER),
    "liquid.viscosity": of(2e-3),
    "liquid.surface_tension": of(2.0, **BUBBLES),
    "liquid.density": of(0.9, **FALLING),
    "particles.name": of("pearl", PICTURE),
    "particles.radius": of(0.99),
    "particles.radii": of([0.9, 0.95]),
    "particles.sizes.distribution": of("uniform", **SIZES),
    "particles.sizes.mean": of(0.97, **SIZES),
    "particles.sizes.spread": of(0.04, **SIZES),
    "particles.sizes.truncate": of(1.0, **SIZES),
    "particles.sizes.radii": of([0.9, 0.97], **HISTOGRAM),
    "particles.sizes.weights": of([1.0, 9.0], **HISTOGRAM),
    "particles.volume_share": of(0.4, **SHARED),
    "particles.modulus": of(2.0),
    "particles.density": of(1.2, **FALLING),
    "particles.positions": of([[0.0, 1.06], [2.05, 1.07]]),
    "particles.count": of(3, **SCATTERED),
    "particles.glued": of("bottom", **WALLS),
    "particles.force": of([1e-3, 1e-5], REFUSED),
    "particles.torque": of([1e-4], rotation=True),
    "particles.color": of("orange", PICTURE),
    "films.surface": of("bubble", liquid={"surface_tension": 1.0}),
    "films.interface": of("mobile"),
    "films.viscosity_ratio": of(0.5, films={"interface": "drop"}),
    "films.friction": of("coulomb", **{**COULOMB, "films": {"roughness": 0.08}}),
    "films.friction_coefficient": of(0.01, **COULOMB),
    "films.roughness": of(0.5, **COULOMB),
    "films.critical_load": of(1.0, **merged(COULOMB, {"films": {"friction": "critical-load", "critical_load": 0.0}})),
    "films.output": of("vectors", FILES),
    "films.tangential_law": of("secant", **SHEAR),
    "films.tension_law": of("symmetric", **SHEAR),
    "films.cavitation_pressure": of(2e-6, films={"tension_law": "cavitation", "cavitation_pressure": 1e-6}, **SHEAR),
    "films.prefactors": of("physical"),
    "films.squeeze": of(2.0),
    "films.shear": of(2.0),
    "films.normal": of(2.0),
    "films.tangential": of(2.0, **SHEAR),
    "films.gap_weight": of(3.0),
    "films.deflection_weight": of(3.0),
    "films.cutoff": of(0.2, hydrodynamics={"drag": "stokes"}),
    "long_range_forces.law": of("none", **STERIC),
    "long_range_forces.steric_strength": of(2e-3, **STERIC),
    "long_range_forces.steric_length": of(0.1, **STERIC),
    "long_range_forces.hamaker_constant": of(2e-6, **DLVO),
    "long_range_forces.double_layer_strength": of(2e-4, **DLVO),
    "long_range_forces.debye_length": of(0.06, **DLVO),
    "long_range_forces.smallest_separation": of(0.02, **DLVO),
    "cell.size": of([4.2, 3.93], **SHEAR),
    "cell.volume_fraction": of(0.5, **SCATTERED),
    "cell.minimum_gap": of(0.1, **SCATTERED),
    "preparation.volume_fraction": of(0.66, **PREPARED),
    "preparation.pressure": of(2e-3, **{**PREPARED, "preparation": {"pressure": 1e-3, "rate": 20.0}}),
    "preparation.rate": of(10.0, **PREPARED),
    "preparation.relaxed": of(1e-3, **PREPARED),
    "walls.side": of("top", walls=[{"side": "bottom"}]),
    "walls.position": of(-0.1, **WALLS),
    "walls.modulus": of(2.0, **WALLS),
    "walls.velocity": of([0.05, 0.0], **WALLS),
    "walls.pressure": of(2e-3, **WALLS),
    "walls.shear_stress": of(1e-3, **WALLS),
    "walls.drained": of(True, **PERMEATED),
    "permeation.law": of("kozeny-carman", REFUSED, **PERMEATED),
    "permeation.permeability": of(2e-3, **PERMEATED),
    "permeation.layer_height": of(1.0, **PERMEATED),
    "protocol.time": of(8e-4, protocol=[{"time": 2e-4, "shear_rate": 0.05}]),
    "protocol.load": of(0.5, protocol=[{"time": 0.0, "load": 1.0}]),
    "protocol.wall_shear": of(
        0.5, protocol=[{"time": 0.0}], walls=[{"side": "bottom"}, {"side": "top", "shear_stress": 1e-3}]
    ),
    "protocol.strain": of(2e-4, protocol=[{"time": 5e-4, "strain": 1e-4}]),
    "protocol.shear_rate": of(0.1, **SHEAR),
    "protocol.rate_steps.rates": of([0.1], protocol=[{"time": 0.0, "rate_steps": {"rates": [0.2], "strain": 5e-5}}]),
    "protocol.rate_steps.strain": of(
        1e-5, protocol=[{"time": 0.0, "rate_steps": {"rates": [0.2, 0.1], "strain": 4e-5}}]
    ),
    "protocol.rate_steps.stationary_within": of(
        0.5, frame_every=1e-5, protocol=[{"time": 0.0, "rate_steps": {"rates": [0.2], "strain": 1e-4}}]
    ),
    "protocol.shear_stress": of(2e-3, protocol=[{"time": 0.0, "shear_stress": 1e-3}]),
    "protocol.oscillation.frequency": of(
        5.0, protocol=[{"time": 0.0, "oscillation": {"frequency": 2.5, "amplitude": 0.01}}]
    ),
    "protocol.oscillation.amplitude": of(
        0.02, protocol=[{"time": 0.0, "oscillation": {"frequency": 2.5, "amplitude": 0.01}}]
    ),
    "protocol.oscillation.stress": of(
        2e-3, protocol=[{"time": 0.0, "shear_stress": 1e-3, "oscillation": {"frequency": 2.5, "stress": 1e-3}}]
    ),
    "protocol.scale": of(0.9998, protocol=[{"time": 5e-4, "scale": 0.9999}]),
    "protocol.height_rate": of(-0.02, protocol=[{"time": 0.0, "height_rate": -0.01}]),
    "protocol.normal_stress": of(2e-3, protocol=[{"time": 0.0, "normal_stress": 1e-3}]),
    "protocol.pressure": of(2e-3, protocol=[{"time": 0.0, "pressure": 1e-3}]),
    "hydrodynamics.drag": of("stokes"),
    "integration.integrator": of("tr-bdf2"),
    "integration.tolerance": of(1e-6),
    "integration.solver": of("iterative"),
}
