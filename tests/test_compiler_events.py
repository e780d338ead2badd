"""Whether something is being compiled."""

import numba
import pytest

from ecume._compiler_events import CompilerWatch


@pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="nothing is compiled without the JIT")
def test_what_is_compiled_is_counted_once():
    watch = CompilerWatch()
    watch.attach()
    watch.attach()

    def half(x):
        return 0.5 * x

    compiled = numba.njit(half)

    assert (watch.count, watch.compiling) == (0, False)
    assert compiled(3.0) == 1.5
    assert (watch.count, watch.compiling) == (1, False)
    compiled(4.0)
    assert watch.count == 1
