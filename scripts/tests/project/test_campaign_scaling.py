"""Tests that the table of the scaling contains the measurements and their extrapolation to a
cluster."""

from __future__ import annotations

import pytest

from scripts.bench_campaign import Measured, table, timed


def test_what_sixty_four_cores_take() -> None:
    found = [
        Measured("nothing", 1, 20, 0.0, 0.6, 1.0),
        Measured("nothing", 1, 2020, 0.0, 1.6, 3.0),
        Measured("set", 2, 10, 50.0, 56.0, 100.0),
    ]
    lines = table(found, 8.0)
    # 2,000 more tasks take 1 s more, which is 0.5 ms for each task. On 64 processes, 10,000 tasks
    # of 5 s take 781 s, plus 3 s to start.
    assert "| set | 2 | 10 | 5 | 56 | 89 | 0.357 | 0.1 |" in lines
    assert "takes 0.5 ms of CPU time per task" in lines[-3]
    assert "10,000 · 5.00 s / 64 + 3 s = 13 min" in lines[-1]
    assert len(lines) == 8


def test_time_of_a_task_is_cpu_time() -> None:
    assert timed({"work": "", "task": {}})["cpu_s"] == pytest.approx(0.0, abs=0.05)
