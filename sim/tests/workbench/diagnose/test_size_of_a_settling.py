"""Tests that the stated size of a settling is that of a plain least-squares fit of the same
rows."""

from __future__ import annotations

import numpy as np
import pytest

from arctrue.measurement import MeasurementSet, Reference, Table
from tests.workbench.base_diagnosis import diagnosis_of

STATIONS, CYCLES = 12, 5
WAIT_S, PAUSE_S = 11.0, 20.0
TAU_S, SIZE_ARCSEC, NOISE_ARCSEC = 420.0, -7.0, 0.4


def _warming(seed: int) -> MeasurementSet:
    """Return five cycles up and down over twelve stations, which settle from the first row on."""
    random = np.random.default_rng([10, seed])
    up = np.arange(STATIONS)
    number = np.tile(np.concatenate([up, up[::-1]]), CYCLES)
    run = np.repeat(np.arange(2 * CYCLES), STATIONS)
    time_s = WAIT_S * (1.0 + np.arange(number.size)) + PAUSE_S * run
    angle = 2.0 * np.pi * number / STATIONS
    error = 4.0 * np.cos(angle - 0.5) + 2.0 * np.sin(2.0 * angle) + np.cos(3.0 * angle)
    error += SIZE_ARCSEC * np.exp(-time_s / TAU_S) + random.normal(0.0, NOISE_ARCSEC, number.size)
    reference = Reference(
        target_deg=np.degrees(angle),
        error_arcsec=error,
        run=run,
        time_s=time_s,
        cycle=run // 2,
        direction=1 - 2 * (run % 2),
    )
    return MeasurementSet(Table(), None, reference)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_size_is_that_of_a_fit_of_the_rows(seed: int) -> None:
    measured = _warming(seed)
    found = diagnosis_of(measured)
    assert found.verdict == "unknown"
    assert found.described is not None
    assert set(found.described.effect.parts) == {"settling", "reference"}
    tau_s = float(found.described.effect.settings["time_constant_s"])
    rows = measured.reference
    assert rows is not None
    assert rows.time_s is not None
    phase = np.outer(np.radians(rows.target_deg), np.arange(1, 4))
    # The time of the set begins with its first row.
    since = np.exp(-(rows.time_s - rows.time_s[0]) / tau_s)
    columns = np.column_stack([since, np.ones(since.size), np.cos(phase), np.sin(phase)])
    own = float(np.linalg.lstsq(columns, rows.error_arcsec, rcond=None)[0][0])
    assert found.description is not None
    stated = float(found.description.split(", ")[-1].rstrip("″"))
    # Two digits are stated; 2 % allow for the columns in which the diagnosis's model differs from
    # this one.
    assert stated == pytest.approx(abs(own), abs=0.05 + 0.02 * abs(own))
