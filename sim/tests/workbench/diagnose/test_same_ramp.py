"""Tests of an even change of a head within every run alike.

The sets are computed in this module, with plain numpy.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray
from sim.tests.workbench.base_diagnosis import diagnosis_of

from arctrue.measurement import Capture, MeasurementSet, Reference, Table
from arctrue.workbench.diagnose.report import sentences
from arctrue.workbench.diagnose.same_ramp import same_ramp
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.observations.build import observations_of

Float = NDArray[np.float64]
COUNTS = 1 << 24
ALPHA_DEG = 33.0
SAMPLES, TURNS = 300, 3
TERMS = [Term(built_in()["graduation_harmonics"](), {})]


def _disc(angle_deg: Float) -> Float:
    return np.asarray(70.0 * np.cos(np.radians(angle_deg) + 0.4))


def _set(
    speeds_deg_s: tuple[float, ...], ramp: Callable[[Float, Float], Float], seed: int = 1
) -> MeasurementSet:
    """Return a set in which head 2 reads ``ramp(turns, seconds)`` arcseconds more, both counted
    from the start of the run; the noise of a head is 0.1″ with a random walk of 0.03″ a run."""
    random = np.random.default_rng(seed)
    size = SAMPLES * TURNS
    columns: dict[str, list[Float]] = {name: [] for name in ("run", "time", "h1", "h2")}
    for run, speed in enumerate(speeds_deg_s):
        turned = np.arange(size) / SAMPLES * np.sign(speed)
        seconds = 360.0 * np.arange(size) / SAMPLES / abs(speed)
        angle = 360.0 * turned + random.uniform(0.0, 360.0)
        for name, place in (("h1", 0.0), ("h2", ALPHA_DEG)):
            walk = np.cumsum(random.normal(size=size)) * 0.03 / np.sqrt(size)
            error = _disc(angle + place) + 0.1 * random.normal(size=size) + walk
            if name == "h2":
                error = error + ramp(turned, seconds)
            columns[name].append(np.round((angle + place + error / 3600.0) / 360.0 * COUNTS))
        columns["run"].append(np.full(size, run))
        columns["time"].append(60.0 * run + seconds)
    joined = {name: np.concatenate(values) for name, values in columns.items()}
    capture = Capture(
        joined["run"].astype(np.int64),
        joined["time"],
        joined["h1"].astype(np.int64),
        joined["h2"].astype(np.int64),
    )
    target = np.tile(np.arange(24) * 15.0, 6)
    reference = Reference(
        target,
        _disc(target) + 0.15 * random.normal(size=target.size),
        time_s=600.0 + 4.0 * np.arange(target.size),
        cycle=np.repeat(np.arange(6), 24),
        direction=np.ones(target.size, dtype=np.int64),
        faces=24,
    )
    table = Table(counts_per_rev=COUNTS, head_separation_deg=ALPHA_DEG, grating_lines=16_384)
    return MeasurementSet(table, capture, reference, title="ramp")


def _coordinates(measured: MeasurementSet) -> tuple[str, ...]:
    found = same_ramp(Residuals(fit(TERMS, observations_of(measured))))
    return () if found is None else found.coordinates


TWO_SPEEDS = (30.0, -30.0, 30.0, -60.0, 60.0)


def test_a_cable_that_winds_up_is_described_with_its_alternatives() -> None:
    """Head 2 is pulled by 0.4″ a turn of the table; both directions and two speeds show that this
    is a function of the angle. Orders 1 to 20 of the disc absorb the ramp within each turn: about
    eight ninths of the slope remain, in the means of the three turns."""
    measured = _set(TWO_SPEEDS, lambda turned, seconds: 0.4 * turned)
    found = diagnosis_of(measured)
    assert found.verdict == "unknown"
    said = sentences(found)[0]
    assert "a cable or hose" in said
    assert "counts that are lost" in said
    assert found.measurement is not None
    assert found.measurement.kind == "turns"
    ramp = same_ramp(Residuals(fit(TERMS, observations_of(measured))))
    assert ramp is not None
    assert ramp.arcsec == pytest.approx(0.4 * TURNS, rel=0.2)


def test_one_speed_in_one_direction_separates_nothing() -> None:
    found = _coordinates(_set((30.0,) * 5, lambda turned, seconds: 0.4 * turned))
    assert set(found) == {"angle", "way", "time", "time and direction"}


def test_a_change_with_the_time_after_each_start() -> None:
    found = _coordinates(_set(TWO_SPEEDS, lambda turned, seconds: 0.05 * seconds))
    assert found == ("time",)


@pytest.mark.parametrize("seed", range(4))
def test_slow_noise_is_no_common_change(seed: int) -> None:
    assert _coordinates(_set(TWO_SPEEDS, lambda turned, seconds: 0.0 * turned, seed)) == ()
