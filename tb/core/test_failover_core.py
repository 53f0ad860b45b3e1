"""Tests that the whole core leaves a failed head out of the mean of three and of four heads."""

from __future__ import annotations

import pytest

from tb.core.mean_core_bench import CAPTURE_DEPTH, LANES
from tb.support.simulation import simulate

OUT_AND_BACK = ("a_head_comes_back_after_its_index", "a_dead_carrier_is_left_out")
"""Names of the tests that run without ``large``: a head is left out after an illegal step, and
returns; the carrier dies.

``tb/mean/test_head_failover.py`` compares each decision and each refusal with the model. In
``make test-large``, ``sim/tests/instrument/test_failover.py`` tests a head that steps against the
others.
"""


@pytest.mark.parametrize(
    ("heads", "testcase"),
    [
        (4, OUT_AND_BACK),
        pytest.param(3, None, marks=pytest.mark.large),
        pytest.param(4, None, marks=pytest.mark.large),
    ],
    ids=["4-out_and_back", "3-all", "4-all"],
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
