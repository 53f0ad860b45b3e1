"""Tests that the weights of the contrasts, uncorrelated combinations of the heads' differences,
follow from a Cholesky factor of the differences' covariance."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from arctrue.workbench.effects.base import FitContext
from arctrue.workbench.effects.capture_block import capture_block
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.observations.build import observations_of
from arctrue.workbench.observations.contrasts import contrast_weights
from arctrue.workbench.observations.rows import CaptureRows
from tests.workbench.heads.four_heads import PLACES_DEG, FourHeads

Float = NDArray[np.float64]

EXACT = 1e-14
"""Tolerance of weights that are near one, in float64."""


@pytest.mark.parametrize("heads", [2, 3, 4])
def test_weights_are_the_inverse_cholesky_factor(heads: int) -> None:
    """The weights equal the inverse Cholesky factor: the differences to head 1 have the covariance
    σ²(I + 1·1ᵀ), and the contrasts are scaled to the variance 2σ² of R₂ − R₁."""
    further = heads - 1
    covariance = np.eye(further) + np.ones((further, further))
    expected = np.sqrt(2.0) * np.linalg.inv(np.linalg.cholesky(covariance))
    assert np.abs(contrast_weights(heads) - expected).max() < EXACT


def test_rows_are_the_contrasts_of_the_readings() -> None:
    """Each row is √(2(k − 1)/k) times the difference between the reading of head k and the mean of
    the readings of the heads before it."""
    table = FourHeads(samples=50)
    measurement = table.measured(1)
    assert measurement.capture is not None
    rows = observations_of(measurement, mask_outliers=False).capture
    assert rows is not None
    assert rows.channel is not None
    assert rows.runs == 3 * 4
    unit = 1_296_000.0 / (1 << 24)
    for run in range(4):
        inside = measurement.capture.run == run
        readings = np.array(
            [
                counts[inside] * unit - 3600.0 * place
                for counts, place in zip(measurement.capture.heads, table.places_deg, strict=True)
            ]
        )
        for head in (2, 3, 4):
            wanted = readings[head - 1] - readings[: head - 1].mean(axis=0)
            wanted *= np.sqrt(2.0 * (head - 1) / head)
            found = rows.difference_arcsec[rows.run == 3 * run + head - 2]
            # The bound is the rounding of float64 for readings of about 10⁷″.
            assert np.abs(found - wanted).max() < 1e-7


class Seen:
    """Errors that each head shows at every sample, computed from the physics with random sizes."""

    def __init__(self, rows: CaptureRows, places_rad: Float, random: np.random.Generator) -> None:
        self.rows, self.places = rows, places_rad
        self.sizes = random.normal(size=64)

    def graduation_harmonics(self, head: int) -> Float:
        disc = self.rows.angle_rad + self.places[head]
        return sum(
            self.sizes[2 * k - 2] * np.cos(k * disc) + self.sizes[2 * k - 1] * np.sin(k * disc)
            for k in range(1, 21)
        )  # type: ignore[return-value]

    def radial_error_motion(self, head: int) -> Float:
        wave = [f(k * self.rows.angle_rad) for k in range(2, 9) for f in (np.cos, np.sin)]
        x, y = (self.sizes[part] @ np.array(wave) for part in (slice(14), slice(14, 28)))
        return np.asarray(x * np.sin(self.places[head]) + y * np.cos(self.places[head]))

    def thermal_head_drift(self, head: int) -> Float:
        assert self.rows.temperature_c is not None
        size = 0.0 if head == 0 else self.sizes[head - 1]
        return np.asarray(size * (self.rows.temperature_c - self.rows.reference_temperature_c))

    def timing_skew(self, head: int) -> Float:
        size = 0.0 if head == 0 else self.sizes[head - 1]
        return np.asarray(size * 1e-6 * self.rows.speed_rad_s * 648_000.0 / np.pi)

    def subdivision_error(self, head: int) -> Float:
        phases = [self.rows.electrical1_rad, self.rows.electrical2_rad]
        if head > 1:
            assert self.rows.further_electrical_rad is not None
            phases += list(self.rows.further_electrical_rad.T)
        own = self.sizes[6 * head : 6 * head + 6]
        waves = [f(k * phases[head]) for k in (1, 2, 4) for f in (np.cos, np.sin)]
        return np.asarray(own @ np.array(waves))

    def thermal_eccentricity(self, head: int) -> Float:
        assert self.rows.temperature_c is not None
        disc = self.rows.angle_rad + self.places[head]
        warmth = self.rows.temperature_c - self.rows.reference_temperature_c
        return np.asarray(warmth * (self.sizes[0] * np.cos(disc) + self.sizes[1] * np.sin(disc)))


@pytest.mark.parametrize("heads", [2, 3, 4])
@pytest.mark.parametrize("name", [name for name in vars(Seen) if not name.startswith("_")])
def test_columns_are_the_contrasts_of_what_each_head_shows(name: str, heads: int) -> None:
    places_deg = PLACES_DEG[:heads]
    measurement = FourHeads(samples=40, places_deg=places_deg).measured(3)
    observations = observations_of(measurement, mask_outliers=False)
    rows = observations.capture
    assert rows is not None
    seen = Seen(rows, np.radians(places_deg), np.random.default_rng(5))
    shown = np.array([getattr(seen, name)(head) for head in range(heads)])
    effect = built_in()[name]()
    columns = capture_block(effect, rows, {}, FitContext())
    assert columns is not None
    width = len(effect.column_names(observations))
    assert columns.shape == (rows.run.size, width)
    found = columns @ seen.sizes[:width]
    for head in range(2, heads + 1):
        inside = slice(None) if rows.channel is None else rows.channel == head - 2
        wanted = shown[head - 1] - shown[: head - 1].mean(axis=0)
        wanted *= np.sqrt(2.0 * (head - 1) / head)
        # The tolerance covers sums of forty waves of about one, computed by powers of e^{jx} up to
        # the 20th.
        assert np.abs(found - wanted)[inside].max() < 1e-11
