"""Tests that the diagnosis names no subdivision error if the column of this effect, which is
computed from noisy readings, fits only the noise of these readings."""

from __future__ import annotations

import numpy as np
import pytest

from arctrue.measurement import Capture, MeasurementSet, Reference, Table
from arctrue.studies.benchmark.diagnosis import diagnosed

LINES = 16_384
COUNTS = 1 << 24
SEEDS = 8


def _polygon(stations: int, seed: int, *, counts: bool, cycles: int = 4) -> MeasurementSet:
    """Return the log of a polygon that contains only an error ε of orders 1 to 3 at equal stations,
    and 0.15″ of noise."""
    random = np.random.default_rng(seed)
    up = np.arange(stations) * 360.0 / stations
    target = np.tile(np.concatenate([up, up[::-1]]), cycles)
    angle = np.radians(target)
    error = 40.0 * np.cos(angle + 0.4) + 2.0 * np.cos(2.0 * angle) + 0.5 * np.cos(3.0 * angle)
    head = random.normal(0.0, 0.1, angle.size)
    error = error + head
    reading = (target + error / 3600.0) / 360.0 * COUNTS
    reference = Reference(
        target,
        error + random.normal(0.0, 0.11, angle.size),
        run=np.zeros(angle.size, dtype=np.int64),
        time_s=np.arange(angle.size) * 4.0,
        cycle=np.repeat(np.arange(cycles), 2 * stations),
        direction=np.tile(np.repeat([1, -1], stations), cycles),
        head1_counts=np.round(reading).astype(np.int64) if counts else None,
    )
    table = Table(grating_lines=LINES, counts_per_rev=COUNTS)
    return MeasurementSet(table, None, reference, title="stations")


@pytest.mark.parametrize("counts", [False, True])
@pytest.mark.parametrize("stations", [3, 6, pytest.param(12, marks=pytest.mark.large)])
def test_nothing_is_taken_for_a_subdivision_error(stations: int, counts: bool) -> None:
    """The diagnosis names no subdivision error for noise of 0.1″, about 1/800 of a signal period. A
    wave that is computed from the phase of a noisy reading contains this noise too."""
    for seed in range(SEEDS):
        _, found = diagnosed(_polygon(stations, seed, counts=counts))
        assert "subdivision_error" not in found.effect_class
        resembles = found.decision.resembles
        assert resembles is None or resembles.name != "subdivision_error"
        assert found.described is None
        if not counts:
            assert found.verdict == "cannot_tell" or "subdivision_error" in found.untestable


LATTICE_LINES = 5_000
"""Lines of the scale. With 2,000 samples per turn there are two and a half lines per sample, so
that the samples have only two phases of the signal."""


def _capture_at_two_phases(seed: int) -> MeasurementSet:
    """Return runs of two heads with an error ε of orders 1 to 3 and 0.2″ of white noise per
    head."""
    random = np.random.default_rng(seed)
    columns: dict[str, list[np.ndarray]] = {"run": [], "time": [], "one": [], "two": []}
    counts, places = 1 << 22, (0.0, np.radians(41.0))
    for run, speed_deg_s in enumerate((20.0, -20.0, 60.0)):
        angle = np.radians(0.18) * np.arange(8_000) * np.sign(speed_deg_s) + 0.7
        columns["run"].append(np.full(angle.size, run))
        columns["time"].append(100.0 * run + 0.18 / abs(speed_deg_s) * np.arange(angle.size))
        for name, place in zip(("one", "two"), places, strict=True):
            disc = angle + place
            error = 9.0 * np.cos(disc + 0.4) + 2.0 * np.cos(2.0 * disc) + 0.5 * np.cos(3.0 * disc)
            error += random.normal(0.0, 0.2, angle.size)
            reading = np.degrees(disc) + error / 3600.0
            columns[name].append(np.round(reading * counts / 360.0).astype(np.int64))
    run, time_s, one, two = (np.concatenate(part) for part in columns.values())
    table = Table(grating_lines=LATTICE_LINES, counts_per_rev=counts, head_separation_deg=41.0)
    return MeasurementSet(table, Capture(run, time_s, one, two), None, title="two phases")


@pytest.mark.large
@pytest.mark.parametrize("seed", range(3))
def test_noise_at_two_phases_is_no_subdivision_error(seed: int) -> None:
    """Noise at two phases is no subdivision error. If ε is small, the model explains most of a wave
    that is sampled at only two phases. The remainder of the wave is mostly noise of the phase; with
    an amplitude of 41″, this remainder would explain all noise."""
    _, found = diagnosed(_capture_at_two_phases(seed))
    assert found.verdict in ("adequate", "cannot_tell")
    assert found.decision.resembles is None
