"""Tests that the product of parts that leaves the least error is the description, even if slow
noise absorbs the error while no product is in the model."""

from __future__ import annotations

import numpy as np
import pytest

from arctrue.measurement import Capture, MeasurementSet, Table
from tests.workbench.base_diagnosis import diagnosis_of

COUNTS = 1 << 24
SPEEDS = (24.0, 48.0, 72.0, -72.0, 96.0)
SAMPLES = 4000


def _with_order_3_of_the_speed(seed: int) -> MeasurementSet:
    """Return one turn at each of five speeds, one after the other; the disc has an error of order 3
    that grows with the square of the speed, 0.9″ at 72°/s. The noise of a head is 0.2″."""
    random = np.random.default_rng(seed)
    columns: dict[str, list[np.ndarray]] = {"run": [], "time": [], "head0": [], "head1": []}
    start_s = 0.0
    for run, speed in enumerate(SPEEDS):
        time_s = start_s + np.arange(SAMPLES) * 360.0 / abs(speed) / SAMPLES
        angle = speed * (time_s - start_s)
        for head, place in enumerate((0.0, 33.0)):
            disc = np.radians(angle + place)
            error = 22.0 * np.cos(disc - 0.4) + 5.0 * np.cos(2.0 * disc - 1.2)
            error = error + 0.9 * (speed / 72.0) ** 2 * np.cos(3.0 * disc)
            error = error + random.normal(0.0, 0.2, SAMPLES)
            counts = (angle + place + error / 3600.0) / 360.0 * COUNTS
            columns[f"head{head}"].append(np.round(counts))
        columns["run"].append(np.full(SAMPLES, run))
        columns["time"].append(time_s)
        start_s = time_s[-1] + 20.0
    joined = {name: np.concatenate(values) for name, values in columns.items()}
    capture = Capture(
        run=joined["run"].astype(np.int64),
        time_s=joined["time"],
        head1_counts=joined["head0"].astype(np.int64),
        head2_counts=joined["head1"].astype(np.int64),
    )
    table = Table(counts_per_rev=COUNTS, head_separation_deg=33.0, grating_lines=16_384)
    return MeasurementSet(table, capture, None)


@pytest.mark.large
def test_the_speed_and_not_the_time_describes_an_error_of_the_speed() -> None:
    """The slowest run is the first, so that a settling from the start gains more than the speed
    while the noise contains the error; with the square of the speed only noise remains."""
    found = diagnosis_of(_with_order_3_of_the_speed(1))
    assert found.verdict == "unknown"
    assert found.described is not None
    assert found.described.effect.parts == ["speed^2", "order:3", "disc"]
