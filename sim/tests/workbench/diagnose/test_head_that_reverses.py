"""Tests that a head that moves with the direction is not taken for friction of the table.

The sets follow the definition: a bracket that leans by ±B/2 with the direction moves the reading of
head 1 alone, so that the reference reads ±B/2 and R₂ − R₁ changes by ∓B/2.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from arctrue.measurement import MeasurementSet
from arctrue.workbench.diagnose.of_the_runs import head_1_reverses
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.noise.spectrum import Spectrum
from arctrue.workbench.observations.build import observations_of
from tests.workbench.base_diagnosis import diagnosis_of
from tests.workbench.small_sets import ARCSEC, COUNTS_PER_REV, measurement_set

REVERSAL_ARCSEC = 2.4
STROKE_RAD = np.radians(20.0)


def _set(of_head_1: float, seed: int, *, scatter_arcsec: float = 0.0) -> MeasurementSet:
    """Return a set with a reversal error, of which head 1 alone moves the share ``of_head_1``.

    The error takes the other sign exponentially within 20° after each reversal.
    ``scatter_arcsec``: standard deviation of the further offsets of the runs.
    """
    random = np.random.default_rng(seed + 100)
    offsets = scatter_arcsec * random.normal(size=4)
    order = iter(offsets)
    made = measurement_set(
        head2_only=lambda time, speed: np.full(
            time.size, -0.5 * REVERSAL_ARCSEC * of_head_1 * np.sign(speed) + next(order)
        ),
        reversal_arcsec=REVERSAL_ARCSEC,
        seed=seed,
        turns=1,
    )
    rows = made.reference
    assert rows is not None
    assert rows.direction is not None
    assert rows.head1_counts is not None
    number = np.arange(rows.target_deg.size)
    travel = np.radians(15.0 * (number % 24))
    back = np.where(
        number < 24, 0.0, -REVERSAL_ARCSEC * rows.direction * np.exp(-travel / STROKE_RAD)
    )
    counts = np.round(back * ARCSEC / (2.0 * np.pi) * COUNTS_PER_REV).astype(np.int64)
    moved = replace(
        rows, error_arcsec=rows.error_arcsec + back, head1_counts=rows.head1_counts + counts
    )
    return replace(made, reference=moved)


def _said(made: MeasurementSet) -> str | None:
    effects = built_in()
    reversal = Term(effects["hysteresis"](transition="exponential"), {"width": 20.0})
    found = fit([Term(effects["graduation_harmonics"](), {}), reversal], observations_of(made))
    return head_1_reverses(Residuals(found), found.parameters()[-1]["reversal_error"])


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_bracket_that_leans_moves_head_1(seed: int) -> None:
    said = _said(_set(1.0, seed))
    assert said is not None
    assert "head 1" in said


def test_slow_noise_does_not_absorb_the_change() -> None:
    """Slow noise of 3″ with a time constant of three times the length of a run."""
    made = observations_of(_set(1.0, 4))
    rows = made.capture
    assert rows is not None
    slow = Spectrum(0.02, np.array([30.0]), np.array([9.0]))
    effects = built_in()
    reversal = Term(effects["hysteresis"](transition="exponential"), {"width": 20.0})
    model = [Term(effects["graduation_harmonics"](), {}), reversal]
    white = fit(model, made)
    capture = replace(white.noise.capture, spectra=(slow,) * rows.runs)
    found = fit(model, made, noise=replace(white.noise, capture=capture))
    assert np.ptp(found.run_offsets_arcsec) < 0.1 * REVERSAL_ARCSEC
    said = head_1_reverses(Residuals(found), found.parameters()[-1]["reversal_error"])
    assert said is not None


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize(
    ("of_head_1", "scatter_arcsec"),
    [(0.0, 0.0), (-1.0, 0.0), (0.5, 0.0), (0.0, REVERSAL_ARCSEC)],
    ids=["friction", "against the reference", "half of the size", "offsets that scatter"],
)
def test_friction_moves_both_heads(of_head_1: float, scatter_arcsec: float, seed: int) -> None:
    """Offsets of the runs contradict friction only with the sign and size of a moving head 1."""
    assert _said(_set(of_head_1, seed, scatter_arcsec=scatter_arcsec)) is None


@pytest.mark.large
@pytest.mark.parametrize(("of_head_1", "verdict"), [(1.0, "unknown"), (0.0, "named")])
def test_the_diagnosis_of_a_bracket_that_leans(of_head_1: float, verdict: str) -> None:
    found = diagnosis_of(_set(of_head_1, 5))
    assert found.verdict == verdict
    first = found.named or found.decision.resembles
    assert first is not None
    assert first.name == "hysteresis"
