"""Floats with inertia and thermal noise: equipartition, diffusion, elastic collisions, flows and work."""

import math
import warnings

import numpy as np
import pytest

from ecume.citing import papers_of
from ecume.engine.philox import counter_of, normals
from ecume.errors import SceneError
from ecume.models import MODELS
from ecume.models.floating.parameters import COLLISIONS, WORK
from ecume.models.floating.time_integration.step_size import KEPT
from tests.models import begun
from tests.models.floating.bowls import WATER, scene_of

FLOATING = MODELS["floating"]
TEMPERATURE = 300.0
THERMAL = 1.380649e-23 * TEMPERATURE
SCHEMES = ("velocity-verlet", "explicit-euler", "semi-implicit-euler", "stormer-verlet")
FREE = '[interaction]\nlaw = "none"\n[contacts]\nlaw = "none"\n'


def warm(floats, *, scheme="velocity-verlet", rest=FREE, flow="", step=None, liquid=WATER, **times):
    """A scene with Brownian motion and inertia."""
    given = "" if step is None else f"time_step = {step!r}\n"
    return scene_of(
        f"{liquid}temperature = {TEMPERATURE}\n{flow}{floats}[hydrodynamics]\nbrownian = true\n"
        f'[integration]\nintegrator = "{scheme}"\n{given}{rest}',
        **times,
    )


def beads(count, spacing=1e-3):
    return (
        f'[[particles]]\ncount = {count}\nradius = 1e-6\ndensity = 1500.0\ncontact_angle = 1.2\nplacement = "lattice"\n'
        f"spacing = {spacing}\n"
    )


def relaxation_of(parameters):
    return float(parameters.floats.relaxation_time[0])


def stepping(scheme, count, ratio=KEPT, flow=""):
    """Free floats whose steps are a part of their relaxation time."""
    tau = relaxation_of(FLOATING.parameters(warm(beads(1))))
    scene = warm(
        beads(count), scheme=scheme, step=ratio * tau, duration=ratio * tau, frame_every=ratio * tau, flow=flow
    )
    return begun(scene)


@pytest.mark.parametrize("scheme", SCHEMES)
def test_velocities_and_displacements_of_free_floats_have_the_variances_of_their_steps(scheme):
    """From rest, n steps of h give <v^2> = kT/m (1 - q^(2n)) with q = exp(-h/tau), and displacements that are sums of
    these velocities. 3,000 independent numbers, whose variance has a standard error of 2.6 %.
    """
    count, steps = 1500, 12
    parameters, state, workspace = stepping(scheme, count)
    before = state.position.copy()
    assert FLOATING.advance(parameters, state, workspace, steps) == 0
    kept, time = math.exp(-KEPT), parameters.time_step
    variance = THERMAL / float(parameters.floats.mass[0])
    # The noise of step k moves a float in the later steps by (q^0 + ... + q^(n-2-k)) h; Stoermer's scheme has the mean
    # of the velocities before and after the kick, which is the same without forces.
    moved = sum(((1.0 - kept**later) / (1.0 - kept)) ** 2 for later in range(1, steps)) * (1.0 - kept**2) * time**2
    bound = 4.5 * math.sqrt(2.0 / (2 * count))
    assert np.mean(state.velocity**2) / variance == pytest.approx(1.0 - kept ** (2 * steps), abs=bound)
    assert np.mean((state.position - before) ** 2) / (variance * moved) == pytest.approx(1.0, abs=bound)
    kinetic = 0.5 * float(np.sum(parameters.floats.mass[:, None] * state.velocity**2))
    assert state.tally[WORK] == pytest.approx(kinetic, rel=1e-12, abs=0.0)


@pytest.mark.parametrize("scheme", SCHEMES)
def test_the_first_step_gives_a_float_at_rest_its_random_number(scheme):
    parameters, state, workspace = stepping(scheme, 3)
    assert FLOATING.advance(parameters, state, workspace, 1) == 0
    drawn = np.array([normals(counter_of(i, 0, 0), parameters.drift.seed) for i in range(3)])
    spread = math.sqrt(THERMAL / float(parameters.floats.mass[0]) * (1.0 - math.exp(-2.0 * KEPT)))
    assert state.velocity == pytest.approx(spread * drawn, rel=1e-9, abs=0.0)


def test_floats_diffuse_as_fast_as_without_inertia_to_three_thousandths():
    """The sum of all displacements after one kick of noise is that of Einstein's D, times (r/2) coth(r/2) for steps of
    r relaxation times.
    """
    parameters = stepping("velocity-verlet", 1)[0]
    kept, tau = math.exp(-KEPT), relaxation_of(parameters)
    per_step = THERMAL / float(parameters.floats.mass[0]) * (0.5 + kept / (1.0 - kept)) * parameters.time_step
    assert per_step == pytest.approx(THERMAL / float(parameters.floats.mass[0]) * tau, rel=4e-3, abs=0.0)
    loose = FLOATING.parameters(warm(beads(1), duration=1e-3, frame_every=1e-3))
    assert loose.time_step <= KEPT * tau * (1.0 + 1e-12)


@pytest.mark.parametrize(("ratio", "said"), [(0.2, ""), (0.5, "1.02"), (2.0, "1.31")])
def test_check_states_how_much_too_fast_floats_diffuse(ratio, said):
    tau = relaxation_of(FLOATING.parameters(warm(beads(1))))
    scene = warm(beads(1), step=ratio * tau, duration=ratio * tau, frame_every=ratio * tau)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        (remark,) = [text for name, _, text in FLOATING.summary(scene) if name == "time step"]
    assert (f"diffuse {said} times" in remark) if said else ("diffuse" not in remark)


def test_its_papers_are_cited():
    assert {"bussi2007", "uhlenbeck1930"} <= set(papers_of(warm(beads(1))))


def test_noise_and_drag_relax_floats_toward_the_flow():
    parameters, state, workspace = stepping("velocity-verlet", 400, flow="[flow]\nvelocity = [0.5, -0.2]\n")
    assert FLOATING.advance(parameters, state, workspace, 60) == 0
    error = 4.5 * math.sqrt(THERMAL / float(parameters.floats.mass[0]) / 400)
    assert state.velocity.mean(axis=0) == pytest.approx([0.5, -0.2], abs=error)


def test_elastic_collisions_do_not_change_the_temperature():
    """A gas of hard discs in a dish, in a liquid of so low viscosity that they collide before they relax."""
    thin = WATER.replace("1 mPa*s", "1e-4 mPa*s")
    rest = (
        '[interaction]\nlaw = "none"\n[contacts]\nrestitution = 1.0\n'
        '[dish]\nsize = [1.5e-5, 1.5e-5]\nlaw = "none"\nrestitution = 1.0\n'
    )
    tau = 1e4 * relaxation_of(FLOATING.parameters(warm(beads(1))))
    step = 0.02 * tau
    scene = warm(beads(25, 2.5e-6), rest=rest, step=step, duration=step, frame_every=step, liquid=thin)
    parameters, state, workspace = begun(scene)
    variance = THERMAL / float(parameters.floats.mass[0])
    state.velocity[:] = math.sqrt(variance) * np.random.default_rng(1).normal(size=state.velocity.shape)
    found = []
    for _ in range(40):
        assert FLOATING.advance(parameters, state, workspace, 5) == 0
        found.append(float(np.mean(state.velocity**2)))
    assert state.tally[COLLISIONS] > 100
    # Kinetic energies are independent after half a relaxation time: 8 samples of 50 numbers.
    assert np.mean(found) / variance == pytest.approx(1.0, abs=3.0 * math.sqrt(2.0 / (8 * 50)))


@pytest.mark.parametrize(
    ("rest", "key"),
    [
        ("[contacts]\nrestitution = 0.5\n", "contacts.restitution: got a restitution of 0.5"),
        ("[contacts]\nlegacy_coefficient = 0.6\n", "contacts.legacy_coefficient: got a restitution of 0.2"),
        (FREE + "[dish]\nradius = 1e-3\nrestitution = 0.5\n", "dish.restitution"),
        ("[contacts]\nrestitution = 1.0\nfriction = 0.1\n", "integration.integrator: Brownian motion with inertia"),
    ],
)
def test_what_would_cool_the_floats_is_refused(rest, key):
    with pytest.raises(SceneError, match=key):
        FLOATING.parameters(warm(beads(2), rest=rest))
