"""Every integrator of floats that claims a capability has it: an option that needs it has the effect that it has with
velocity Verlet. An integrator that claims a capability and ignores the option fails.
"""

import dataclasses

import numpy as np
import pytest
from tests.models.floating.bowls import HEAVY, WATER, scene_of

from ecume.models.floating.time_integration import integrators
from ecume.models.floating.time_integration.integrators import INTEGRATORS, _row, predict_runge_kutta
from ecume.simulation import simulate

ACCURACY = 0.06
"""Tolerated difference from velocity Verlet, over the effect of the option: a scheme without inertia is the least
accurate, by the relaxation time over a radian of the dish's motion.
"""
STEPS, DURATION = 200, 0.2
OPTIONS = {
    "fast drag": (WATER, {"hydrodynamics": 'drag = "schiller-naumann"\n'}),
    "sways": (WATER.replace("1 mPa*s", "100 mPa*s"), {"dish": 'motion = { amplitude = "1 mm", frequency = "1 Hz" }\n'}),
}
"""By the capability that it needs: the liquid, and the lines that choose the option."""
CLAIMS = [(name, capability) for name, row in INTEGRATORS.items() for capability in OPTIONS if capability in row.gives]


def end_with(integrator, capability, *, chosen):
    """The final position of a single float in a dish without a meniscus, with or without the option."""
    liquid, lines = OPTIONS[capability]
    tables = {"dish": 'radius = 0.1\nlaw = "none"\n', "hydrodynamics": ""}
    tables["integration"] = f'integrator = "{integrator}"\ntime_step = {DURATION / STEPS!r}\n'
    if chosen:
        tables = {name: text + lines.get(name, "") for name, text in tables.items()}
    tables["hydrodynamics"] = tables["hydrodynamics"] or 'drag = "stokes"\n'
    moving = "velocity = [0.2, 0.0]\n" if capability == "fast drag" else ""
    floats = f"[[particles]]\n{HEAVY}positions = [[0.0, 0.0]]\n{moving}"
    rest = "".join(f"[{name}]\n{text}" for name, text in tables.items())
    *_, last = simulate(scene_of(f"{liquid}{floats}{rest}", duration=DURATION, frame_every=DURATION))
    return last.arrays["position"][0]


@pytest.mark.parametrize(("integrator", "capability"), CLAIMS)
def test_an_option_acts_as_with_velocity_verlet(integrator, capability):
    wanted = end_with("velocity-verlet", capability, chosen=True)
    effect = np.linalg.norm(wanted - end_with("velocity-verlet", capability, chosen=False))
    assert effect > 1e-4
    assert np.linalg.norm(end_with(integrator, capability, chosen=True) - wanted) < ACCURACY * effect


@pytest.mark.uncompiled  # compiled code has its functions already
@pytest.mark.parametrize("capability", OPTIONS)
def test_a_claim_that_is_false_is_noticed(capability, monkeypatch):
    """The classical Runge-Kutta scheme has no drag by speed, and here no force of the dish."""
    monkeypatch.setattr(integrators, "add_dish_force", lambda parameters, time, force: None)
    boastful = dataclasses.replace(INTEGRATORS["rk4"], gives=INTEGRATORS["rk4"].gives | {capability})
    monkeypatch.setitem(INTEGRATORS, "rk4", boastful)
    with pytest.raises(AssertionError):
        test_an_option_acts_as_with_velocity_verlet("rk4", capability)


def test_functions_without_a_type_of_constants_are_refused():
    with pytest.raises(TypeError, match="integrator 'mine': got predict without constants"):
        _row("mine", INTEGRATORS["rk4"].scheme, frozenset(), predict=predict_runge_kutta)
