"""Tests that the diagnosis finds an effect although the noise that is estimated with this effect in
the model absorbs a part of the effect."""

from __future__ import annotations

import numpy as np
import pytest
from sim.tests.workbench.base_diagnosis import diagnosis_of

from arctrue.measurement import Capture, MeasurementSet, Table

COUNTS = 1 << 20
COUNT_ARCSEC = 1_296_000.0 / COUNTS
SEED = 11


def _warming_run() -> MeasurementSet:
    """Make one run of three turns, in which order 2 grows by 1.7″/K while the table warms by 4 K.

    The noise of head 2, 0.43″, is correlated over 12 rows.
    """
    random = np.random.default_rng(SEED)
    rows = 3_000
    angle = np.radians(np.arange(rows) * 360.0 * 3.0 / rows + random.uniform(0.0, 360.0))
    noise, kept = np.zeros(rows), float(np.exp(-1.0 / 12.0))
    for row in range(1, rows):
        noise[row] = kept * noise[row - 1] + np.sqrt(1.0 - kept**2) * random.standard_normal()
    time_s = np.arange(rows) * 0.003
    warm = 4.0 * time_s / time_s[-1] + 0.005 * random.standard_normal(rows)

    def error(disc: np.ndarray) -> np.ndarray:
        changing = (4.0 + 1.7 * warm) * np.cos(2.0 * disc + 1.0)
        return np.asarray(30.0 * np.cos(disc) + changing)

    def counts(disc: np.ndarray, own: np.ndarray | float) -> np.ndarray:
        reading = np.degrees(disc) * 3600.0 + error(disc) + own
        return np.asarray(np.round(reading / COUNT_ARCSEC).astype(np.int64))

    capture = Capture(
        run=np.zeros(rows, dtype=np.int64),
        time_s=time_s,
        head1_counts=counts(angle, 0.0),
        head2_counts=counts(angle + np.radians(33.0), 0.43 * noise),
        temperature_c=20.0 + warm,
    )
    table = Table(counts_per_rev=COUNTS, head_separation_deg=33.0)
    return MeasurementSet(table, capture, None, title="warming run")


@pytest.mark.large
def test_an_order_that_grows_with_warmth_is_no_line_next_to_the_order() -> None:
    """A sine 0.05 orders from order 2 fits three turns nearly as well, with one parameter more.

    If the noise is estimated with this sine in the model, temperature times order 2 explains at
    least as much as the sine.
    """
    found = diagnosis_of(_warming_run())
    assert found.verdict == "unknown"
    assert found.described is not None
    assert set(found.described.effect.parts) >= {"temperature", "order:2", "disc"}
