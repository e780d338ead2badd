"""Counter-based random numbers: functions of particle, step and purpose, independent of threads and restarts.

Philox4x32-10 [salmon2011]: ten rounds of multiplication scramble a counter under a key.
"""

from __future__ import annotations

import math

from ecume._jit import compiled_inside

WORD = 0xFFFFFFFF
MULTIPLIER_0, MULTIPLIER_1 = 0xD2511F53, 0xCD9E8D57
WEYL_0, WEYL_1 = 0x9E3779B9, 0xBB67AE85
ROUNDS = 10
Words = tuple[int, int, int, int]


@compiled_inside
def philox(counter: Words, key: tuple[int, int]) -> Words:
    """Four random words of 32 bits, from a counter and a key."""
    a, b, c, d = counter
    k, m = key
    for _ in range(ROUNDS):
        # Products of two words overflow signed 64 bits, but their high and low halves are still correct.
        first, second = MULTIPLIER_0 * a, MULTIPLIER_1 * c
        a, b, c, d = (
            ((second >> 32) & WORD) ^ b ^ k,
            second & WORD,
            ((first >> 32) & WORD) ^ d ^ m,
            first & WORD,
        )
        k, m = (k + WEYL_0) & WORD, (m + WEYL_1) & WORD
    return a, b, c, d


@compiled_inside
def uniforms(counter: Words, seed: int) -> tuple[float, float]:
    """Two numbers in (0, 1), with 53 random bits each, from a counter (four words) and a seed."""
    a, b, c, d = philox(counter, (seed & WORD, (seed >> 32) & WORD))
    return ((a >> 6) * 134217728.0 + (b >> 5) + 0.5) / 2.0**53, ((c >> 6) * 134217728.0 + (d >> 5) + 0.5) / 2.0**53


@compiled_inside
def normals(counter: Words, seed: int) -> tuple[float, float]:
    """Two independent, normally distributed numbers with mean 0 and variance 1, by the Box-Muller transform."""
    first, second = uniforms(counter, seed)
    away, angle = math.sqrt(-2.0 * math.log(first)), 2.0 * math.pi * second
    return away * math.cos(angle), away * math.sin(angle)


PAIRS = 1 << 16
"""The first purpose of pairs, above those of single particles."""


@compiled_inside
def counter_of_pair(first: int, second: int, when: int, turn: int) -> Words:
    """The counter of a pair of particles, or of a particle and a wall, for a step and the number of their collision in
    it.
    """
    what = PAIRS * (1 + (int(turn) & 0x7FFF)) + ((int(when) >> 32) & 0xFFFF)
    return int(first) & WORD, int(when) & WORD, int(second) & WORD, what


@compiled_inside
def counter_of(who: int, when: int, what: int) -> Words:
    """The counter of a particle, a step and a purpose."""
    return int(who) & WORD, int(when) & WORD, (int(when) >> 32) & WORD, int(what)
