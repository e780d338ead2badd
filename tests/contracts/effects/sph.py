"""Effects of the keys of tanks."""

from . import EXPORT, FILES, OUTPUT, PICTURE, REFUSED, STOPS, of

BASE = {
    "model": "sph", "duration": 0.05, "frame_every": 0.05, "spacing": 0.25, "gravity": [0.0, -1.0],
    "liquid": {"density": 1.0, "sound_speed": 10.0, "maximum_speed": 1.0},
    "tank": {"high": [1.0, 1.0], "top": {"kind": "open"}},
    "fluid": [{"low": [0.0, 0.0], "high": [1.0, 0.5], "velocity": [0.3, 0.1]}],
}  # fmt: skip
DISC = {"low": None, "high": None, "center": [0.5, 0.5], "radius": 0.4}
POLYGON = {"low": None, "high": None, "vertices": [[0.0, 0.0], [0.9, 0.0], [0.0, 0.8]]}
PLACED = {"low": None, "high": None, "particles": {"positions": [[0.3, 0.3], [0.5, 0.3]]}}
TETRAHEDRON = [[[0, 0, 0], [0, 1, 0], [1, 0, 0]], [[0, 0, 0], [1, 0, 0], [0, 0, 1]], [[0, 0, 0], [0, 0, 1], [0, 1, 0]],
               [[1, 0, 0], [0, 1, 0], [0, 0, 1]]]  # fmt: skip
DEEP = {"duration": 0.01, "frame_every": 0.01, "gravity": [0.0, -1.0, 0.0], "tank": {"high": [1.0, 1.0, 1.0]},
        "fluid": [{"low": [0.0, 0.0, 0.0], "high": [1.0, 0.5, 1.0], "velocity": [0.3, 0.1, 0.2]}]}  # fmt: skip
PLACED_DEEP = {**DEEP, "fluid": [{"low": None, "high": None, "velocity": None,
                                  "particles": {"positions": [[0.5, 0.15, 0.5], [0.2, 0.2, 0.3]]}}]}  # fmt: skip
"""No liquid is packed around a cylinder, which takes long as plain Python."""
FULL = {"tank": {"top": {"kind": "wall"}}, "fluid": [{"high": [1.0, 1.0]}]}
VISCOUS = {"liquid": {"viscosity": 0.02}}
STRAINED = {"fluid": [{"velocity_gradient": [[0.0, 1.0], [0.0, 0.0]]}]}
YIELDING = {"liquid": {"rheology": {"consistency": 0.02, "yield_stress": 0.01}}, **STRAINED}
SOLVED = {"method": {"pressure": "incompressible", "jitter": 0.2}, "liquid": {"sound_speed": None}}
WATER = {"liquid": {"name": "water", "density": None}}
TENSE = {"liquid": {"surface_tension": 0.02}}
SINE = {"amplitude": 0.05, "frequency": 1.0}
TABLE = {"times": [0.0, 0.1], "positions": [0.0, 0.02]}
INFLOW = {"tank": {"left": {"kind": "inflow", "speed": 0.2, "level": 0.5},
                   "right": {"kind": "outflow", "level": 0.5}}}  # fmt: skip
SHAKE = {"base_excitation": {"amplitude": [0.5, 0.0], "frequency": 1.0}}
TABULATED = {"base_excitation": {"times": [0.0, 0.1], "accelerations": [[0.0, 0.0], [0.5, 0.0]]}}
FAST = {"fluid": [{"velocity": [0.0, -8.0]}], "tank": {"walls": "reflect"}}
CYLINDER = {"center": [0.5, 0.5, 0.5], "radius": 0.2, "axis": [0.0, 0.4, 0.0]}
UPRIGHT_CYLINDER = {"low": None, "high": None, "velocity": None, **CYLINDER}
OBSTACLE = {"obstacles": [{"low": [0.4, 0.0], "high": [0.6, 0.3]}]}
ROUND_OBSTACLE = {"obstacles": [{"center": [0.5, 0.1], "radius": 0.15}]}
BODY = {"bodies": [{"low": [0.3, 0.4], "high": [0.7, 0.8], "density": 0.5}]}
TURNED = {**DEEP, "bodies": [{"low": [0.3, 0.3, 0.3], "high": [0.6, 0.7, 0.7], "motion": {"spin": 1.0}}]}
ROUND_BODY = {"bodies": [{"center": [0.5, 0.6], "radius": 0.2, "density": 0.5}]}
FALLING = {"bodies": [{"low": [0.3, 0.01], "high": [0.7, 0.4], "density": 2.0, "velocity": [0.5, -2.0]}],
           "fluid": [{"low": [0.0, 0.5], "high": [1.0, 0.9]}]}  # fmt: skip
TRACERS = {"passive_tracers": [{"positions": [[0.3, 0.2]]}]}
GRAINS = {"passive_tracers": [{"positions": [[0.3, 0.2]], "radius": 0.01, "density": 2.0}], **VISCOUS}
SCATTERED = {"passive_tracers": [{"count": 3, "low": [0.1, 0.1], "high": [0.9, 0.4]}]}
EDDIES = {"method": {"turbulence": "smagorinsky"}, **TRACERS}
DISPERSED = {"method": {"turbulence": "smagorinsky"},
             "passive_tracers": [{"positions": [[0.3, 0.2]], "turbulent_dispersion": True}]}  # fmt: skip
GAUGE = {"gauges": [{"name": "P", "position": [0.5, 0.1]}]}
ROW = {"gauges": [{"name": "P", "position": [0.2, 0.1], "end": [0.8, 0.1], "count": 2}]}
PULL = {"central_force": {"angular_frequency": 1.0, "center": [0.5, 0.5]}, "gravity": [0.0, 0.0]}
TRANSPORT = {"method": {"pressure_force": "transport"}, **FULL}
TWO = {"second_liquid": {"density": 0.5},
       "fluid": [{"high": [0.5, 0.5]}, {"low": [0.5, 0.0], "high": [1.0, 0.5], "liquid": "second"}]}  # fmt: skip
TWO_VISCOUS = {**TWO, "second_liquid": {"density": 0.5, "viscosity": 0.02}, **VISCOUS}
TWO_NAMED = {**TWO, "liquid": {"density": None, "viscosity": 0.001}, "second_liquid": {"name": "glycerol"}}
LID = {"tank": {"bottom": {"velocity": [0.2, 0.0]}}, **VISCOUS}
SIDES = ("left", "right", "bottom", "top", "front", "back")

REGIONS = {"fluid": [{"high": [0.5, 0.5]}, {"low": [0.5, 0.0], "high": [1.0, 0.5]}]}
PUSH = {"user_laws": [{"law": "push", "constants": [1e-3]}], **REGIONS}
EVERY = {"output": {"samples": {"every": 0.01}}}


def moved(**motion):
    """A tank with a body that follows this path."""
    return {"bodies": [{"low": [0.3, 0.4], "high": [0.7, 0.8], "motion": motion}]}


EFFECTS = {
    **OUTPUT,
    "output.samples.every": of(0.02, FILES, **EVERY),
    "user_laws.law": of("hold", **PUSH),
    "user_laws.species": of(["fluid-1", "fluid-1"], **PUSH),
    "user_laws.constants": of([2e-3], **PUSH),
    "model": of("tracers", REFUSED),
    "title": of("another", PICTURE),
    "duration": of(0.1),
    "frame_every": of(0.025),
    "seed": of(1, method={"jitter": 0.2}),
    "on_violation": of("stop", STOPS),
    "spacing": of(0.125),
    "gravity": of([0.1, -1.0]),
    "up": of("z", **{**DEEP, "gravity": 1.0}),
    "liquid.name": of("glycerol", **WATER),
    "liquid.temperature": of(350.0, **WATER),
    "liquid.salinity": of(0.03, liquid={"name": "seawater", "density": None}),
    "liquid.density": of(2.0),
    "liquid.viscosity": of(0.05),
    "liquid.surface_tension": of(1e-3),
    "liquid.contact_angle": of(1.0, **TENSE),
    "liquid.sound_speed": of(12.0),
    "liquid.maximum_speed": of(2.0, liquid={"sound_speed": None}),
    "liquid.tait_exponent": of(1.0),
    "liquid.atmospheric_pressure": of(1e5, EXPORT),
    "liquid.rheology.consistency": of(0.03, **YIELDING),
    "liquid.rheology.exponent": of(0.7, **YIELDING),
    "liquid.rheology.yield_stress": of(0.02, **YIELDING),
    "liquid.rheology.largest_viscosity": of(0.025, **YIELDING),
    "second_liquid.name": of("ethanol", **TWO_NAMED),
    "second_liquid.temperature": of(310.0, **TWO_NAMED),
    "second_liquid.density": of(0.25, **TWO),
    "second_liquid.viscosity": of(0.05, **TWO_VISCOUS),
    "second_liquid.interface_tension": of(0.02, **TWO),
    "second_liquid.sound_speed": of(20.0, **TWO),
    "second_liquid.tait_exponent": of(1.0, **TWO),
    "fluid.liquid": of(
        "first",
        **{
            **TWO,
            "fluid": [
                {"high": [0.5, 0.25], "liquid": "second"},
                *TWO["fluid"][1:],
                {"low": [0.0, 0.25], "high": [0.5, 0.5]},
            ],
        },
    ),
    "fluid.low": of([0.25, 0.0]),
    "fluid.high": of([1.0, 0.75]),
    "fluid.vertices": of([[0.0, 0.0], [0.9, 0.0], [0.2, 0.9]], fluid=[POLYGON]),
    "fluid.center": of([0.5, 0.55], fluid=[DISC]),
    "fluid.radius": of(0.3, fluid=[DISC]),
    "fluid.triangles": of(
        [[[0.9 * x for x in corner] for corner in face] for face in TETRAHEDRON],
        **{**DEEP, "fluid": [{"low": None, "high": None, "velocity": None, "triangles": TETRAHEDRON}]},
    ),
    "fluid.axis": of([0.0, 0.5, 0.0], **{**DEEP, "fluid": [UPRIGHT_CYLINDER]}),
    "fluid.velocity": of([0.2, 0.0]),
    "fluid.velocity_gradient": of([[0.1, 0.0], [0.0, -0.1]]),
    "fluid.flow": of("poiseuille"),
    "fluid.flow_speed": of(0.5, fluid=[{"flow": "poiseuille"}]),
    "fluid.color": of("orange", PICTURE),
    "fluid.particles.positions": of([[0.3, 0.3], [0.5, 0.4]], fluid=[PLACED]),
    "fluid.particles.velocities": of([[0.1, 0.0], [0.0, 0.0]], fluid=[PLACED]),
    "fluid.particles.densities": of([1.01, 1.0], fluid=[PLACED]),
    "fluid.particles.masses": of([0.07, 0.06], fluid=[PLACED]),
    "tank.low": of([-0.25, 0.0]),
    "tank.high": of([1.25, 1.0]),
    "tank.walls": of("dummy"),
    "tank.restitution": of(0.9, **FAST),
    "tank.tangential_restitution": of(0.5, tank={"walls": "reflect"}, fluid=[{"velocity": [3.0, -8.0]}]),
    "tank.left.restitution": of(0.9, tank={"walls": "reflect"}, fluid=[{"velocity": [-8.0, 0.0]}]),
    "tank.left.tangential_restitution": of(0.5, tank={"walls": "reflect"}, fluid=[{"velocity": [-8.0, 1.0]}]),
    "tank.left.kind": of("open"),
    "tank.left.slip": of("no-slip", liquid={"viscosity": 0.05}, tank={"left": {"slip": "free"}}),
    "tank.left.contact_angle": of(1.0, **TENSE),
    "tank.left.velocity": of([0.0, 0.5], **VISCOUS),
    "tank.left.speed": of(0.3, **INFLOW),
    "tank.left.profile": of("parabolic", **INFLOW),
    "tank.left.level": of(0.3, **INFLOW),
    "tank.left.pressure": of(
        0.2, tank={"right": {"kind": "inflow", "speed": 0.2, "level": 0.5}, "left": {"kind": "outflow", "level": 0.5}}
    ),
    "tank.left.motion.amplitude": of(0.06, tank={"left": {"motion": SINE}}),
    "tank.left.motion.frequency": of(2.0, tank={"left": {"motion": SINE}}),
    "tank.left.motion.phase": of(0.5, tank={"left": {"motion": SINE}}),
    "tank.left.motion.times": of([0.0, 0.2], tank={"left": {"motion": TABLE}}),
    "tank.left.motion.positions": of([0.0, 0.01], tank={"left": {"motion": TABLE}}),
    "tank.left.motion.formula": of("0.2*t", tank={"left": {"motion": {"formula": "0.1*t"}}}),
    "obstacles.low": of([0.3, 0.0], **OBSTACLE),
    "obstacles.high": of([0.7, 0.3], **OBSTACLE),
    "obstacles.vertices": of(
        [[0.3, 0.0], [0.6, 0.0], [0.5, 0.3]], obstacles=[{"vertices": [[0.3, 0.0], [0.7, 0.0], [0.5, 0.3]]}]
    ),
    "obstacles.center": of([0.55, 0.1], **ROUND_OBSTACLE),
    "obstacles.radius": of(0.2, **ROUND_OBSTACLE),
    "obstacles.triangles": of(
        [[[0.9 * x for x in corner] for corner in face] for face in TETRAHEDRON],
        **{**DEEP, "obstacles": [{"triangles": TETRAHEDRON}]},
    ),
    "obstacles.axis": of([0.0, 0.5, 0.0], **{**PLACED_DEEP, "obstacles": [CYLINDER]}),
    "obstacles.hollow": of(True, obstacles=[{"vertices": [[0.5, -0.1], [1.1, -0.1], [1.1, 1.0], [0.5, 1.0]]}]),
    "obstacles.contact_angle": of(1.0, **TENSE, **OBSTACLE),
    "obstacles.slip": of(
        "no-slip", **{**OBSTACLE, "obstacles": [{**OBSTACLE["obstacles"][0], "slip": "free"}]}, **VISCOUS
    ),
    "obstacles.restitution": of(0.9, tank={"walls": "reflect"}, fluid=[{"velocity": [8.0, 0.0]}], **OBSTACLE),
    "obstacles.tangential_restitution": of(
        0.5, tank={"walls": "reflect"}, fluid=[{"velocity": [8.0, 1.0]}], **OBSTACLE
    ),
    "obstacles.color": of("orange", PICTURE, **OBSTACLE),
    "obstacles.name": of("post", **OBSTACLE),
    "bodies.low": of([0.2, 0.4], **BODY),
    "bodies.high": of([0.8, 0.8], **BODY),
    "bodies.vertices": of(
        [[0.3, 0.4], [0.6, 0.4], [0.5, 0.8]],
        bodies=[{"vertices": [[0.3, 0.4], [0.7, 0.4], [0.5, 0.8]], "density": 0.5}],
    ),
    "bodies.triangles": of(
        [[[0.9 * x for x in corner] for corner in face] for face in TETRAHEDRON],
        **{**DEEP, "bodies": [{"triangles": TETRAHEDRON, "density": 0.5}]},
    ),
    "bodies.axis": of([0.0, 0.5, 0.0], **{**PLACED_DEEP, "bodies": [{**CYLINDER, "density": 0.5}]}),
    "bodies.center": of([0.55, 0.6], **ROUND_BODY),
    "bodies.radius": of(0.15, **ROUND_BODY),
    "bodies.density": of(0.8, **BODY),
    "bodies.mass": of(0.2, bodies=[{"low": [0.3, 0.4], "high": [0.7, 0.8], "mass": 0.1}]),
    "bodies.velocity": of([0.1, 0.0], **BODY),
    "bodies.spin": of(1.0, **BODY),
    "bodies.motion.velocity": of([0.2, 0.0], **moved(velocity=[0.1, 0.0])),
    "bodies.motion.spin": of(2.0, **moved(spin=1.0)),
    "bodies.motion.start": of(0.02, **moved(velocity=[0.1, 0.0])),
    "bodies.motion.until": of(0.02, **moved(velocity=[0.1, 0.0])),
    "bodies.motion.amplitude": of([0.06, 0.0], **moved(amplitude=[0.05, 0.0], frequency=1.0)),
    "bodies.motion.angle_amplitude": of(0.2, **moved(angle_amplitude=0.1, frequency=1.0)),
    "bodies.motion.frequency": of(2.0, **moved(amplitude=[0.05, 0.0], frequency=1.0)),
    "bodies.motion.phase": of(0.5, **moved(amplitude=[0.05, 0.0], frequency=1.0)),
    "bodies.motion.times": of([0.0, 0.2], **moved(times=[0.0, 0.1], angles=[0.0, 0.1])),
    "bodies.motion.positions": of(
        [[0.0, 0.0], [0.02, 0.0]], **moved(times=[0.0, 0.1], positions=[[0.0, 0.0], [0.01, 0.0]])
    ),
    "bodies.motion.angles": of([0.0, 0.2], **moved(times=[0.0, 0.1], angles=[0.0, 0.1])),
    "bodies.motion.formula": of(["0.2*t", "0"], **moved(formula=["0.1*t", "0"])),
    "bodies.motion.angle_formula": of("2*t", **moved(angle_formula="t")),
    "bodies.motion.pivot": of([0.4, 0.5], **moved(spin=1.0)),
    "bodies.motion.axis": of([0.0, 1.0, 0.0], **TURNED),
    "bodies.contact_angle": of(1.0, **TENSE, **BODY),
    "bodies.slip": of("no-slip", bodies=[{**BODY["bodies"][0], "slip": "free"}], **VISCOUS),
    "bodies.restitution": of(0.9, **FALLING),
    "bodies.friction": of(0.0, **FALLING),
    "bodies.color": of("orange", PICTURE, **BODY),
    "bodies.name": of("raft", **BODY),
    "passive_tracers.positions": of([[0.4, 0.2]], **TRACERS),
    "passive_tracers.count": of(4, **SCATTERED),
    "passive_tracers.low": of([0.2, 0.1], **SCATTERED),
    "passive_tracers.high": of([0.8, 0.4], **SCATTERED),
    "passive_tracers.radius": of(0.02, **GRAINS),
    "passive_tracers.density": of(3.0, **GRAINS),
    "passive_tracers.turbulent_dispersion": of(True, **EDDIES),
    "passive_tracers.schmidt_number": of(0.1, **DISPERSED),
    "passive_tracers.color": of("orange", PICTURE, **TRACERS),
    "gauges.name": of("Q", **GAUGE),
    "gauges.position": of([0.5, 0.2], **GAUGE),
    "gauges.diameter": of(0.2, **GAUGE),
    "gauges.end": of([0.7, 0.1], **ROW),
    "gauges.count": of(3, **ROW),
    "gauges.quantities": of(["absolute_pressure"], **GAUGE),
    "base_excitation.amplitude": of([0.6, 0.0], **SHAKE),
    "base_excitation.frequency": of(2.0, **SHAKE),
    "base_excitation.phase": of(0.5, **SHAKE),
    "base_excitation.times": of([0.0, 0.2], **TABULATED),
    "base_excitation.formula": of(["0.6*t", "0"], base_excitation={"formula": ["0.5*t", "0"]}),
    "roll.amplitude": of(0.2, roll={"amplitude": 0.1, "frequency": 1.0}),
    "roll.frequency": of(2.0, roll={"amplitude": 0.1, "frequency": 1.0}),
    "roll.phase": of(0.5, roll={"amplitude": 0.1, "frequency": 1.0}),
    "roll.formula": of("2*t", roll={"formula": "t"}),
    "roll.pivot": of([0.4, 0.5], roll={"formula": "t"}),
    "roll.axis": of([0.0, 1.0, 0.0], **DEEP, roll={"formula": "t"}),
    "base_excitation.accelerations": of([[0.0, 0.0], [0.6, 0.0]], **TABULATED),
    "central_force.angular_frequency": of(2.0, **PULL),
    "central_force.center": of([0.4, 0.5], **PULL),
    "method.pressure": of("incompressible", liquid={"sound_speed": None}),
    "method.kernel": of("wendland-c4"),
    "method.smoothing_ratio": of(1.8),
    "method.nonnegative_wall_pressure": of(False, tank={"walls": "dummy"}, fluid=[{"velocity": [3.0, 0.0]}]),
    "method.density_diffusion": of("none"),
    "method.diffusion_coefficient": of(0.2, method={"jitter": 0.2}),
    "method.artificial_viscosity": of(0.1),
    "method.acoustic_damping": of(1.0, method={"jitter": 0.2}),
    "method.viscosity_model": of("morris", **VISCOUS),
    "method.pressure_force": of("monaghan"),
    "method.pressure_split": of("modified", **FULL),
    "method.allow_invalid_split": of(True, REFUSED, method={"pressure_split": "original"}),
    "method.initial_pressure": of("zero"),
    "method.jitter": of(0.2),
    "method.turbulence": of("smagorinsky", fluid=[{"velocity_gradient": [[0.0, 1.0], [0.0, 0.0]]}]),
    "method.surface_tension_model": of("none", **TENSE),
    "method.shifting": of("none", **{**FULL, "method": {"jitter": 0.2}}),
    "method.background_pressure": of(200.0, **TRANSPORT),
    "method.precision": of("single"),
    "integration.integrator": of("verlet"),
    "integration.time_step": of(0.005),
    "integration.courant_number": of(0.2),
    "integration.pressure_tolerance": of(1e-9, **SOLVED),
    "integration.pressure_iterations": of(1, STOPS, **SOLVED),
}
