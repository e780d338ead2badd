"""Sequences of discrete states, such as topologies of clusters: transition counts and entropy production."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from typing import NamedTuple

import numpy as np

from ecume.analysis.clusters import Integers
from ecume.analysis.series import BLOCKS, Mean
from ecume.errors import BadInput
from ecume.units import Array


class Transitions(NamedTuple):
    """How often a sequence changed from each state to each other one."""

    states: tuple[str, ...]
    """most frequent first"""
    visits: Integers
    """(S,) instants in each state"""
    counts: Integers
    """(S, S) changes from the row's state to the column's between neighboring instants; the diagonal counts stays"""

    @property
    def probabilities(self) -> Array:
        """(S, S): the probability of the column's state at the next instant; 0 for states without a successor."""
        total = self.counts.sum(axis=1, keepdims=True)
        return np.asarray(np.divide(self.counts, total, out=np.zeros(self.counts.shape), where=total > 0))

    @property
    def currents(self) -> Integers:
        """(S, S): net changes from the row's state to the column's; zero on average in equilibrium."""
        return np.asarray(self.counts - self.counts.T)


def transitions(sequence: Sequence[Hashable]) -> Transitions:
    """Count the transitions of a sequence of states.

    >>> transitions(["dimer", "dimer", "trimer", "dimer"]).counts.tolist()
    [[1, 1], [1, 0]]
    """
    states, numbers, visits = _numbered(sequence)
    return Transitions(tuple(map(str, states)), visits, _counts(numbers, len(states)))


def entropy_production(sequences: Sequence[Sequence[Hashable]], every: float, blocks: int = BLOCKS) -> Mean:
    """The entropy production rate of steady sequences of states at distances of `every` seconds (k_B/s).

    The rate is the sum over pairs of states of the net current times ln(n_ij/n_ji), with the numbers n_ij of changes
    [schnakenberg1976]. It is a lower bound: what the states do not resolve is not counted. The product of a
    current and a ratio from the same changes is positive even in equilibrium. Therefore each sequence is cut into
    blocks, and the current of each block is multiplied by the ratio, with 1/2 added to each count, of all others. In
    equilibrium the mean is zero if blocks are longer than the memory of the sequences. The error is that of the mean
    over blocks; one block suffices where there are several independent sequences.
    """
    if blocks * len(sequences) < 2 or any(len(each) < 4 * blocks for each in sequences):
        raise BadInput(
            f"got {len(sequences)} sequences, the shortest of {min(map(len, sequences), default=0)} states, for "
            f"{blocks} blocks each; expected 2 blocks or more, and 4 states for each"
        )
    states, numbers, _ = _numbered([state for each in sequences for state in each])
    ends = np.cumsum([len(each) for each in sequences])[:-1]
    cut = [part for each in np.split(numbers, ends) for part in np.array_split(each, blocks)]
    parts = [_counts(part, len(states)) for part in cut]
    total = np.sum(parts, axis=0)
    rates = []
    for part in parts:
        other = total - part + 0.5
        affinity = np.log(other / other.T)
        rates.append(0.5 * float(np.sum((part - part.T) * affinity)) / (every * int(part.sum())))
    return Mean(float(np.mean(rates)), float(np.std(rates, ddof=1) / np.sqrt(len(rates))))


class Cycle(NamedTuple):
    """A cycle of three states and the net number of its turns."""

    states: tuple[str, str, str]
    turns: float
    """smallest of the three net currents, all of them in this direction; 0 where they differ in sign"""
    affinity: float
    """ln of the product of counts in this direction over that in the opposite one, with 1/2 added to each"""


def cycles(found: Transitions) -> list[Cycle]:
    """The cycles of three states, in the direction of their net currents; most turns first."""
    net, counts = found.currents, found.counts + 0.5
    triples = []
    for a in range(len(net)):
        for b in range(a + 1, len(net)):
            for c in range(b + 1, len(net)):
                around = (a, b, c) if net[a, b] + net[b, c] + net[c, a] >= 0 else (a, c, b)
                steps = list(zip(around, (*around[1:], around[0]), strict=True))
                affinity = sum(float(np.log(counts[i, j] / counts[j, i])) for i, j in steps)
                i, j, k = around
                names = (found.states[i], found.states[j], found.states[k])
                triples.append(Cycle(names, float(max(min(net[step] for step in steps), 0)), affinity))
    return sorted(triples, key=lambda cycle: -cycle.turns)


def _numbered(sequence: Sequence[Hashable]) -> tuple[list[Hashable], Integers, Integers]:
    """The states, most frequent first, the sequence as their numbers, and the instants in each."""
    visits: dict[Hashable, int] = {}
    for state in sequence:
        visits[state] = visits.get(state, 0) + 1
    states = sorted(visits, key=lambda state: -visits[state])
    number = {state: index for index, state in enumerate(states)}
    numbers = np.array([number[state] for state in sequence], dtype=np.int64)
    return states, numbers, np.array([visits[state] for state in states], dtype=np.int64)


def _counts(numbers: Integers, states: int) -> Integers:
    pairs = numbers[:-1] * states + numbers[1:]
    return np.bincount(pairs, minlength=states * states).reshape(states, states).astype(np.int64)
