"""Laws of your own: a repulsion between two species of floats, and a trap for tracers.

Run it with `python examples/own_laws.py`. On the command line, give `--laws examples/own_laws.py:repulsion`.
"""

import ecume

FLOATS = """
model = "floating"
duration = "2 s"
frame_every = "0.5 s"

[liquid]
viscosity = "10 mPa*s"

[[particles]]
name = "oats"
radius = "1 mm"
density = 1300
contact_angle = "90 deg"
positions = [["-4 mm", "0 mm"], ["4 mm", "0 mm"]]

[[particles]]
name = "nuts"
radius = "1 mm"
density = 1300
contact_angle = "90 deg"
positions = [["0 mm", "3 mm"], ["0 mm", "-3 mm"]]

[[user_laws]]
law = "repulsion"
species = ["oats", "nuts"]
constants = [2e-10]
"""

TRACERS = """
model = "tracers"
duration = "2 s"
frame_every = "0.5 s"
gravity = 0

[liquid]
viscosity = "10 mPa*s"

[[particles]]
radius = "0.5 mm"
density = 1300
positions = [["5 mm", "0 mm"], ["0 mm", "8 mm"]]

[[user_laws]]
law = "trap"
constants = [4.0]
"""


def repulsion(distance, parameters):
    """A force (N) inversely proportional to the distance; positive: repulsion."""
    return parameters.constants[0] / distance


def trap(position, velocity, time, parameters):
    """An acceleration (m/s^2) toward the origin, with the angular frequency of the constant."""
    x, y = position
    pull = -(parameters.constants[0] ** 2)
    return pull * x, pull * y


def main():
    """Print how the energies change."""
    for text, law in ((FLOATS, repulsion), (TRACERS, trap)):
        for frame in ecume.simulate(ecume.load_scene(text), extra_laws=[law]):
            energy, work = (frame.numbers.get(name, 0.0) for name in ("total_energy", "injected_work"))
            print(f"{law.__name__}: t = {frame.time:g} s, energy {energy:.3e} J, injected work {work:.3e} J")


if __name__ == "__main__":
    main()
