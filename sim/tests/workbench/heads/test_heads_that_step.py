"""Tests of heads that gain counts at one instant."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from arctrue.measurement import MeasurementSet
from arctrue.workbench.diagnose.report import sentences
from arctrue.workbench.diagnose.steps_of_heads import heads_that_step
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.observations.build import observations_of
from tests.workbench.base_diagnosis import diagnosis_of
from tests.workbench.heads.four_heads import FourHeads


def _stepping(steps: tuple[int, ...], seed: int = 1) -> MeasurementSet:
    """Return a set whose heads gain these counts in the middle of run 1."""
    made = FourHeads().measured(seed)
    assert made.capture is not None
    counts = {}
    for number, (values, step) in enumerate(zip(made.capture.heads, steps, strict=True), start=1):
        changed = np.array(values)
        changed[800 + 400 : 1600] += step
        counts[f"head{number}_counts"] = changed
    return replace(made, capture=replace(made.capture, **counts))


@pytest.mark.parametrize("run", [5.0, -2.0], ids=["head 4", "head 1"])
@pytest.mark.parametrize(
    ("steps", "heads", "counts"),
    [
        ((0, 0, 40, 40), "3 and 4", (40, 40)),
        ((0, 25, -40, 0), "2 and 3", (25, -40)),
        ((60, 60, 0, 0), "3 and 4", (-60, -60)),
        ((0, 0, 40, 0), None, ()),
        ((40, 0, 0, 0), None, ()),
        ((0, 0, 0, 0), None, ()),
    ],
)
def test_the_heads_that_step_are_listed(
    steps: tuple[int, ...], heads: str | None, counts: tuple[int, ...], run: float
) -> None:
    for seed in (1, 2, 3):
        observations = observations_of(_stepping(steps, seed), mask_outliers=False)
        rows = observations.capture
        assert rows is not None
        place = {"run": run, "instant": float(rows.time_s[rows.run == 5][400])}
        residuals = Residuals(fit([Term(built_in()["graduation_harmonics"](), {})], observations))
        said = heads_that_step(residuals, place)
        if heads is None:
            assert said is None
            continue
        assert said is not None
        assert said.startswith(f"heads {heads} step at the same instant, by ")
        found = [int(word) for word in said.split("by ")[1].split(" counts")[0].split(" and ")]
        # The means of 16 readings of 0.1″ before and after differ by 0.035″, 0.46 counts, of noise.
        assert np.abs(np.array(found) - counts).max() <= 4 * 0.46 + 0.5


@pytest.mark.large
def test_equal_slips_of_two_heads_are_said_to_be_of_two_heads() -> None:
    found = diagnosis_of(_stepping((0, 0, 40, 40)))
    assert found.verdict == "unknown"
    assert "heads 3 and 4 step at the same instant" in sentences(found)[0]
