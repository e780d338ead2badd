"""The queue returns events in the order of their times, also after changes."""

import numpy as np
import pytest

from ecume.engine.contact.event_queue import make_event_queue, schedule


@pytest.mark.parametrize("seed", range(5))
def test_events_come_in_the_order_of_their_times(seed):
    dice, rows = np.random.default_rng(seed), 60
    queue, expected = make_event_queue(rows), {}
    for _ in range(1000):
        row, time = int(dice.integers(rows)), float(dice.random()) if dice.random() < 0.7 else np.inf
        schedule(queue, row, time)
        expected[row] = time
        due = {row: time for row, time in expected.items() if time < np.inf}
        assert queue.size[0] == len(due)
        if due:
            first = int(queue.heap[0])
            assert queue.time[first] == due[first] == min(due.values())
    order = []
    while queue.size[0]:
        order.append(queue.time[queue.heap[0]])
        schedule(queue, int(queue.heap[0]), np.inf)
    assert order == sorted(time for time in expected.values() if time < np.inf)
