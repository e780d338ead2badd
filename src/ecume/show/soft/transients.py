"""Figures of transients: start-up of a flow, relaxation of the stress after it, recovery of the strain after creep."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure

from ecume.analysis.transients import recovery, relaxation, since, start_up
from ecume.errors import BadInput
from ecume.models.soft.protocol import SHEAR, ProtocolState, begun
from ecume.scenes.soft import SoftScene, expanded
from ecume.show.curves import Frames, titled
from ecume.show.soft.measures import require_box
from ecume.show.style import MUTED, PALETTE, figure, scale_for, style


class Turn(NamedTuple):
    """A moment of the protocol, with the shear before and after it."""

    before: ProtocolState
    after: ProtocolState
    start: float
    """s"""
    end: float
    """s: the next moment; infinite after the last"""
    since: float
    """s: the moment at which the shear before it began"""

    @property
    def starts(self) -> bool:
        """Whether a flow at an imposed rate begins."""
        return self.after.shear_rate != 0.0 and self.before.shear_rate == 0.0

    @property
    def stops(self) -> bool:
        """Whether a flow ends, with a constant strain from then on."""
        return self.before.shear_rate != 0.0 and self.after.shear_rate == 0.0 and not self.after.stressed

    @property
    def releases(self) -> bool:
        """Whether a shear stress is removed."""
        return bool(self.before.stressed and self.before.values[SHEAR] and not self.after.values[SHEAR])


def turns(scene: SoftScene) -> Iterator[Turn]:
    """The moments of the protocol."""
    course, previous = ProtocolState(), 0.0
    stages = expanded(scene.protocol)
    for stage, following in itertools.zip_longest(stages, stages[1:]):
        after = begun(course, stage)
        yield Turn(course, after, stage.time, math.inf if following is None else following.time, previous)
        if shear_of(after) != shear_of(course):
            previous = stage.time
        course = after


def shear_of(state: ProtocolState) -> tuple[bool, float, float]:
    """Whether a stress controls the shear, that stress, and the shear rate."""
    return bool(state.stressed), float(state.values[SHEAR]), state.shear_rate


def start_ups(frames: Frames, scene: SoftScene) -> Figure:
    """The shear stress over the strain since each flow began, with the peak and the steady stress."""
    require_box(scene, "stress")
    frames = list(frames)
    found = [(turn, start_up(since(frames, turn.start, turn.end))) for turn in turns(scene) if turn.starts]
    if not found:
        raise BadInput("no flow at a shear_rate begins in the protocol, after a moment without")
    scale = scale_for(max(one.peak for _, one in found), frames[0].units["shear_stress"])
    with style():
        drawn = figure(6.4, 4.2)
        axes = drawn.add_subplot(xlabel="strain since the start", ylabel=f"shear stress ({scale.unit})")
        for (turn, one), color in zip(found, itertools.cycle(PALETTE)):
            over = "not stationary" if np.isnan(one.overshoot) else f"overshoot {100.0 * one.overshoot:.2g} %"
            axes.plot(
                one.strain, scale.factor * one.stress, color=color, label=f"{turn.after.shear_rate:.3g} /s, {over}"
            )
            axes.plot(one.peak_strain, scale.factor * one.peak, "o", color=color, markersize=5)
            if one.steady.settled:
                axes.axhline(scale.factor * one.steady.mean.value, color=color, linestyle=":", linewidth=1.0)
        axes.set_title(titled("Start-up", scene))
        axes.legend()
    return drawn


def relaxations(frames: Frames, scene: SoftScene) -> Figure:
    """The shear stress over the time since each flow stopped, relative to that at its end."""
    require_box(scene, "stress")
    frames = list(frames)
    found = [(turn, relaxation(since(frames, turn.start, turn.end))) for turn in turns(scene) if turn.stops]
    if not found:
        raise BadInput("no flow stops in the protocol; a moment with shear_rate = 0 stops it")
    with style():
        drawn = figure(6.4, 4.2)
        axes = drawn.add_subplot(xlabel="time since the stop (s)", ylabel="shear stress / stress at the stop")
        for (turn, one), color in zip(found, itertools.cycle(PALETTE)):
            label = (
                f"after {turn.before.shear_rate:.3g} /s: {100.0 * one.left:.3g} % left, half in {one.half_time:.2g} s"
            )
            axes.plot(one.time[1:], one.stress[1:] / one.stress[0], color=color, label=label)
        axes.set(xscale="log", title=titled("Relaxation", scene))
        axes.axhline(0.0, color=MUTED, linewidth=0.8)
        axes.legend()
    return drawn


def recoveries(frames: Frames, scene: SoftScene) -> Figure:
    """The recovered strain after each removal of a shear stress, over the strain of the preceding creep."""
    require_box(scene, "strain")
    frames = list(frames)
    found = [
        recovery([frame for frame in frames if frame.time < turn.end * (1.0 - 1e-9)], turn.since, turn.start)
        for turn in turns(scene)
        if turn.releases
    ]
    if not found:
        raise BadInput("no shear_stress is removed in the protocol; a moment with shear_stress = 0 removes it")
    with style():
        drawn = figure(6.4, 4.2)
        axes = drawn.add_subplot(
            xlabel="time since the stress was removed (s)", ylabel="recovered / strain of the creep"
        )
        for one, color in zip(found, itertools.cycle(PALETTE)):
            label = f"{100.0 * one.part:.3g} % of a strain of {one.crept:.3g}"
            axes.plot(one.time[1:], one.recovered[1:] / one.crept, color=color, label=label)
        axes.set(xscale="log", title=titled("Recovery after creep", scene))
        axes.legend()
    return drawn


TRANSIENT_FIGURES = {"start-up": start_ups, "relaxation": relaxations, "recovery": recoveries}
