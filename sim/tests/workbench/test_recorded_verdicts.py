"""Tests that a change which must not alter results leaves the recorded verdicts unchanged.

``make test`` diagnoses two of the recorded sets again, ``make test-large`` two more that take
longer; the four sets come from four worlds (kinds of disturbances) and have different contents
(hidden causes). ``python -m scripts.record_verdicts --check`` diagnoses all 40.
"""

from __future__ import annotations

import copy

import pytest
from sim.tests.workbench.recorded_verdicts import (
    SETS,
    differences,
    recorded,
    tasks,
    verdict_of,
)

from arctrue.studies.benchmark.digests import set_name

SAMPLE = (0, 13, 22, 35)
LARGE = (13, 22, 35)


@pytest.mark.parametrize(
    "number", [pytest.param(one, marks=[pytest.mark.large] * (one in LARGE)) for one in SAMPLE]
)
def test_the_verdict_is_as_recorded(number: int) -> None:
    task = tasks()[number]
    assert list(differences(recorded()[set_name(task)], verdict_of(task))) == []


def test_every_set_is_recorded() -> None:
    assert list(recorded()) == [set_name(task) for task in tasks()]
    assert len(recorded()) == SETS


def test_a_difference_is_found() -> None:
    before = next(iter(recorded().values()))
    now = copy.deepcopy(before)
    now["verdict"] = "bad_data"
    now["candidates"][0]["delta_bic"] *= 1.01
    now["candidates"][0]["p_corrected"] = 0.5
    del now["masked"]
    places = [text.split(":")[0] for text in differences(before, now)]
    assert places == ["/candidates/0/delta_bic", "/candidates/0/p_corrected", "/masked", "/verdict"]
