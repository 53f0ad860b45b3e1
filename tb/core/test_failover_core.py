"""Tests that the whole core leaves a failed head out of the mean of three and of four heads."""

from __future__ import annotations

import pytest

from tb.core.mean_core_bench import CAPTURE_DEPTH, LANES
from tb.support.simulation import simulate

WAYS_AND_RETURN = (
    "a_dead_carrier_is_left_out",
    "a_head_that_is_too_fast_is_left_out",
    "a_small_slip_is_found_at_the_index/slip=4",
    "the_parity_shows_a_slip_at_once",
    "a_head_comes_back_after_its_index",
)
RAMP = (
    "a_failover_obeys_the_limits_of_the_ramp/acceleration=0",
    "a_failover_obeys_the_limits_of_the_ramp/acceleration=4294967295",
)
"""Names of the tests that run without ``large``: a head is dead, too fast or slips, the parity
shows a slip, and a head returns after an illegal step.

``sim/tests/instrument/test_failover.py`` tests a head that steps against the others;
``tb/mean/test_head_failover.py`` compares each decision and each refusal with the model.
"""


@pytest.mark.parametrize(
    ("heads", "testcase"),
    [
        (4, WAYS_AND_RETURN),
        (4, RAMP),
        pytest.param(3, None, marks=pytest.mark.large),
        pytest.param(4, None, marks=pytest.mark.large),
    ],
    ids=["4-ways_and_return", "4-ramp", "3-all", "4-all"],
)
def test_failover_core(heads: int, testcase: tuple[str, ...] | None) -> None:
    simulate(
        "arctrue_core",
        "tb.core.failover_core_bench",
        generics={
            "LANES": LANES,
            "CAPTURE_DEPTH": CAPTURE_DEPTH,
            "HEADS": heads,
            "FAILOVER": "true",
        },
        testcase=testcase,
        environment={
            "HEADS": str(heads),
            "ANY_HEAD_MAY_FAIL": "yes",
            **({"QUICK": "yes"} if testcase else {}),
        },
    )
