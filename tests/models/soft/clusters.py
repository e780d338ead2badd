"""Scenes and steps for tests, and an independent solution of the T1 process."""

import math

import numpy as np

from ecume.laws.soft_contacts import TANGENTIAL, TENSION
from ecume.models.law_codes import code_of
from ecume.models.model import CROWDED
from ecume.models.soft import SOFT
from ecume.models.soft.contacts.films import Films, Pairs, contact_response, make_responses
from ecume.models.soft.parameters import Contacts
from ecume.scenes.soft import FilmSpec, IntegrationSpec, SoftLiquid, SoftScene, SphereSpec

PAPER = (1.5 * math.pi, math.pi, 1.0, 1.0, 1.0, 1.0)
LOPSIDED = (4.0, 3.0, 0.8, 0.6, 1.2, 0.7)


def contacts(prefactors=PAPER, viscosity=1.0, **more):
    """The common constants of contacts, without long-range force and with unlimited reach."""
    given = {
        "fade_from": math.inf, "fade_to": math.inf, "rounding": 1e-12, "remote": 0, "strength": 0.0,
        "steric_length": 1.0, "hamaker": 0.0, "layer_strength": 0.0, "debye_length": 1.0, "smallest_separation": 0.0,
        "surface": 0, "surface_tension": 1.0, "interface": 0, "viscosity_ratio": 1.0, "friction": 0,
        "coefficient": 0.0, "roughness": 1.0, "critical_load": 0.0, "tangential_law": "potential",
        "tension_law": "symmetric", "cavitation_pressure": 1.0,
    } | more  # fmt: skip
    for table, key in ((TANGENTIAL, "tangential_law"), (TENSION, "tension_law")):
        given[key] = code_of(table, given[key])
    return Contacts(viscosity, *prefactors, **given)


def pull_apart(gap, force, *, tolerance=1e-9, duration, frames=1, prefactors="paper", turn=0.0, more=()):
    """A scene of two unit spheres of modulus and viscosity 1 that a constant force separates or compresses."""
    axis = np.array([math.cos(turn), math.sin(turn), *more])
    axis /= np.linalg.norm(axis)
    spheres = tuple(
        SphereSpec(
            radius=1.0,
            modulus=1.0,
            positions=(tuple(sign * (1 + gap / 2) * axis),),
            force=tuple(sign * force * axis),
        )
        for sign in (-1.0, 1.0)
    )
    return SoftScene(
        duration=duration,
        frame_every=duration / frames,
        liquid=SoftLiquid(viscosity=1.0),
        particles=spheres,
        films=FilmSpec(prefactors=prefactors),
        integration=IntegrationSpec(tolerance=tolerance),
    )


def integrated(scene, *, parts=1):
    """The state at the end of a scene; it is copied, and its scratch made anew, after so many calls."""
    parameters = SOFT.parameters(scene)
    state = SOFT.start(scene, parameters)
    end = round(scene.duration / scene.frame_every) * parameters.steps_per_frame
    while state.step[0] < end:
        state = type(state)(*(array.copy() for array in state))
        work = SOFT.workspace(parameters, state, 1.0)
        for _ in range(parts):
            if SOFT.advance(parameters, state, work, 1) == CROWDED or state.step[0] == end:
                break
    return parameters, state


def one_contact(given, between, log_gap, direction, span, start=None):
    """The linear response of a contact between two different spheres."""
    space = np.zeros((1, 3))
    pairs = Pairs(
        np.array([0]),
        np.array([1]),
        space.copy(),
        space.copy(),
        space[:0],
        np.array([1.7]),
        np.array([0.4]),
        np.array([2.3]),
        (),
        np.zeros((1, 2)),
    )
    n = np.zeros((1, 3))
    n[0, : len(direction)] = direction / np.linalg.norm(direction)
    begin = (np.array([log_gap]), n.copy()) if start is None else start
    films = Films(np.array([log_gap]), n, *begin)
    found = make_responses(1)
    contact_response(given, pairs, films, np.array([np.zeros(len(between)), between]), span, found)
    return found


class Referee:
    """The T1 process in its mirror-symmetric subspace: ln of three gaps and the turn of the diagonals; forces balance
    in two directions. Written from the equations, with nothing from the package.
    """

    def __init__(self, gap, kappa, ramp=0.01):
        self.kappa, self.ramp = kappa, ramp
        self.place = np.array([1 + gap / 2, math.sqrt(3) * (1 + gap / 2)])
        far = math.sqrt(3) * (2 + gap) - 2
        self.begin = np.array([math.log(gap), math.log(far), math.log(gap), math.pi / 3])

    def forces(self, y, place):
        """Tensions of the horizontal, vertical and diagonal pairs, the sliding force of the diagonal, contact sizes and
        gaps.
        """
        gaps, n = np.exp(y[:3]), np.array([math.cos(y[3]), math.sin(y[3])])
        stretch = np.array([2 * place[0], 2 * place[1], place @ n]) - 2 - gaps
        size = np.sqrt(gaps + np.abs(stretch))
        return size * stretch, size[2] * (place @ [-n[1], n[0]]), size, gaps, n

    def left(self, place, y, pull):
        """The residual forces on the left and on the top sphere."""
        tension, slide, _, _, n = self.forces(y, place)
        pulls = n * tension[2] + slide * np.array([-n[1], n[0]])
        return np.array([tension[0] + 2 * pulls[0], -pull - tension[1] - 2 * pulls[1]])

    def balance(self, time, y):
        """Newton's method for the positions at constant gaps."""
        pull = math.sqrt(3) * self.kappa * min(time / self.ramp, 1.0)
        for _ in range(30):
            left = self.left(self.place, y, pull)
            slope = np.array([(self.left(self.place + step, y, pull) - left) / 1e-7 for step in 1e-7 * np.eye(2)]).T
            move = np.linalg.solve(slope, -left)
            self.place = self.place + move
            if np.abs(move).max() < 1e-13:
                break

    def rate(self, time, y):
        """The rates of gaps: each film flows under the force of its surfaces."""
        self.balance(time, y)
        tension, slide, size, gaps, _ = self.forces(y, self.place)
        opening = tension * gaps**2 / (1.5 * math.pi * self.kappa * size**4)
        return [*opening, slide * gaps[2] / (math.pi * self.kappa * size[2] ** 2) / (2 + gaps[2])]

    def missing(self, time, y):
        """The force of the vertical pair minus nine tenths of the external force."""
        self.balance(time, y)
        return -self.forces(y, self.place)[0][1] - 0.9 * math.sqrt(3) * self.kappa if y[1] < y[0] else -1.0
