"""Tests of two heads at 90°, whose blind orders a polygon of 12 or 24 faces hardly determines."""

from __future__ import annotations

import numpy as np
import pytest
from sim.tests.workbench.base_diagnosis import diagnosis_of

from arctrue.measurement import Capture, MeasurementSet, Reference, Table
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.observations.build import observations_of

COUNTS = 1 << 24
COUNT_ARCSEC = 1_296_000.0 / COUNTS
ARCSEC = np.pi / 648_000.0


def _error(angle_rad: np.ndarray) -> np.ndarray:
    return np.asarray(
        20.0 * np.cos(angle_rad + 0.4)
        + 4.0 * np.cos(2.0 * angle_rad)
        + 2.0 * np.cos(4.0 * angle_rad + 1.0)
    )


def _slope(angle_rad: np.ndarray) -> np.ndarray:
    """Return dε/dψ of :func:`_error`, written out by hand."""
    return ARCSEC * np.asarray(
        -20.0 * np.sin(angle_rad + 0.4)
        - 8.0 * np.sin(2.0 * angle_rad)
        - 8.0 * np.sin(4.0 * angle_rad + 1.0)
    )


def _table(faces: int, head_angle_arcsec: float) -> MeasurementSet:
    """Make two runs of three turns and five cycles of a polygon; head 2 is off by the given
    angle."""
    random = np.random.default_rng(6)
    rows = 1_800
    up = np.arange(rows) * 3.0 * 2.0 * np.pi / rows
    angle = np.concatenate([up, up[::-1]])
    place = 0.5 * np.pi + head_angle_arcsec * ARCSEC
    heads = []
    for where in (0.0, place):
        error = _error(angle + where) + random.normal(0.0, 0.08, angle.size)
        heads.append(np.round(((angle + where) / ARCSEC + error) / COUNT_ARCSEC).astype(np.int64))
    capture = Capture(
        run=np.repeat([0, 1], rows),
        time_s=np.concatenate([np.arange(rows), rows + 300.0 + np.arange(rows)]) * 0.01,
        head1_counts=heads[0],
        head2_counts=heads[1],
    )
    stations = np.arange(faces) * 360.0 / faces
    target = np.tile(np.concatenate([stations, stations[::-1]]), 5)
    error = _error(np.radians(target)) + random.normal(0.0, 0.15, target.size)
    reference = Reference(
        target,
        error,
        time_s=5.0 * np.arange(target.size),
        cycle=np.repeat(np.arange(5), 2 * faces),
        direction=np.tile(np.repeat([1, -1], faces), 5),
        head1_counts=np.round((target * 3600.0 + error) / COUNT_ARCSEC).astype(np.int64),
        faces=faces,
    )
    table = Table(counts_per_rev=COUNTS, grating_lines=16_384, head_separation_deg=90.0)
    return MeasurementSet(table, capture, reference, title="heads at 90 degrees")


@pytest.mark.large
@pytest.mark.parametrize("faces", [12, 24])
def test_a_head_that_is_a_minute_of_arc_off_is_named(faces: int) -> None:
    """In both runs, the mean of R₂ − R₁ differs from 90° by 60″, 777 counts."""
    named = diagnosis_of(_table(faces, 60.0)).named
    assert named is not None
    assert named.name == "head_angle_error"


@pytest.mark.parametrize("faces", [12, 24])
def test_the_slope_of_the_model_is_that_of_the_table(faces: int) -> None:
    """Orders that the heads cannot observe and the polygon hardly determines add no large slope.

    At 12 faces, orders n and 12 − n look the same. The heads determine all orders except multiples
    of 4. Orders 4 and 8 may therefore share the amplitude of 2″ in any proportion: the slope is at
    most 8·2″, while the true slope of order 4 is 4·2″. The bound is twice the sum of both.
    """
    observations = observations_of(_table(faces, 0.0))
    solution = fit([Term(built_in()["graduation_harmonics"](), {})], observations)
    angle = np.linspace(0.0, 2.0 * np.pi, 1_000, endpoint=False)
    wrong = solution.context.error_slope(angle) - _slope(angle)
    assert np.abs(wrong).max() < 2.0 * (8.0 + 4.0) * 2.0 * ARCSEC
