"""Metropolis Monte Carlo of hard discs, which knows neither time nor forces: independent of any integrator."""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

Positions = NDArray[np.float64]


def monte_carlo(count: int, side: float, sweeps: int, seed: int, every: int = 5) -> Positions:
    """Configurations (K, N, 2) of hard discs of radius 1 in a periodic square, after a tenth of the sweeps."""
    dice = np.random.default_rng(seed)
    place = lattice(count, side)
    step, kept = 0.5, []
    for sweep in range(sweeps):
        accepted = moved(place, side, dice.integers(count, size=count), dice.uniform(-step, step, (count, 2)))
        if sweep < sweeps // 10:
            step *= 1.05 if accepted > 0.5 * count else 0.95
        elif sweep % every == 0:
            kept.append(place.copy())
    return np.array(kept)


@numba.njit
def moved(place: Positions, side: float, chosen: NDArray[np.int64], moves: Positions) -> int:
    """The number of moves that were accepted; changes the positions."""
    accepted = 0
    for i, move in zip(chosen, moves):  # noqa: B905  # Numba knows no strict zip
        x, y = (place[i, 0] + move[0]) % side, (place[i, 1] + move[1]) % side
        free = True
        for j in range(len(place)):
            across, along = place[j, 0] - x, place[j, 1] - y
            across, along = across - side * np.round(across / side), along - side * np.round(along / side)
            free = free and (j == i or across * across + along * along >= 4.0)
        if free:
            place[i, 0], place[i, 1] = x, y
            accepted += 1
    return accepted


def lattice(count: int, side: float) -> Positions:
    """A square lattice of discs."""
    across = int(np.ceil(np.sqrt(count)))
    spots = (np.arange(across) + 0.5) * side / across
    return np.array([(x, y) for x in spots for y in spots])[:count]


def gap_counts(place: Positions, side: float, edges: NDArray[np.float64]) -> NDArray[np.float64]:
    """The mean number of pairs in each interval of gaps, in radii, of configurations (K, N, 2)."""
    i, j = np.triu_indices(place.shape[1], 1)
    counts = np.zeros(len(edges) - 1)
    for each in place:
        away = each[i] - each[j]
        away -= side * np.round(away / side)
        counts += np.histogram(np.sqrt((away**2).sum(axis=1)) - 2.0, edges)[0]
    return np.asarray(counts / len(place))
