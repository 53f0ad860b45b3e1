"""Tests that every further numeric column is a condition, which ``compare`` and ``diagnose`` use by
the column's name."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from sim.tests.workbench.small_sets import ARCSEC, COUNTS_PER_REV, measurement_set

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.workbench.compare.comparison import compare
from arctrue.workbench.diagnose.adopted import adopt
from arctrue.workbench.diagnose.diagnosis import Diagnosis, diagnose
from arctrue.workbench.effects.product_of_parts import ProductOfParts
from arctrue.workbench.effects.registry import built_in, catalogue
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.observations.build import observations_of
from arctrue.workbench.observations.column_unit import column_unit

EFFECTS = built_in()
LOBES_ARCSEC_PER_NM = 0.06


def _base() -> Term:
    return Term(EFFECTS["graduation_harmonics"](), {})


def _loaded() -> MeasurementSet:
    """Return a set in which the disc has two lobes that grow with a load of 12 ± 8 N·m; the load
    has three periods per run."""
    measurement = measurement_set(seed=7)
    capture = measurement.capture
    assert capture is not None
    place = np.arange(capture.run.size)
    load = 12.0 + 8.0 * np.sin(2.0 * np.pi * place / 1200.0 + 0.7 * capture.run)
    humidity = 40.0 + 5.0 * np.cos(place / 977.0)
    head2 = capture.head2_counts.astype(np.float64)
    count = 2.0 * np.pi / COUNTS_PER_REV
    angle = capture.head1_counts * count
    for head, sign in ((1, -1.0), (2, 1.0)):
        disc = angle + (head - 1) * np.radians(33.0)
        size = LOBES_ARCSEC_PER_NM * load * ARCSEC
        head2 += sign * size * np.cos(2.0 * disc + 0.8) / count
    return replace(
        measurement,
        reference=None,
        capture=replace(
            capture,
            head2_counts=np.round(head2).astype(np.int64),
            conditions={"humidity": humidity, "load_nm": load},
        ),
    )


@pytest.fixture(scope="module")
def loaded() -> Diagnosis:
    return diagnose(observations_of(_loaded()), [_base()], EFFECTS)


@pytest.mark.large
def test_an_effect_that_grows_with_a_column_is_described_by_it(loaded: Diagnosis) -> None:
    assert loaded.verdict == "unknown"
    assert loaded.described is not None
    effect = loaded.described.effect
    assert isinstance(effect, ProductOfParts)
    assert effect.parts == ["load_nm", "order:2", "disc"]
    size = loaded.described.parameters()["amplitude"]
    assert size.unit == "arcsec/N·m"
    assert size.value == pytest.approx(LOBES_ARCSEC_PER_NM, abs=4.0 * size.sigma)
    assert "(load_nm − 12)" in (loaded.description or "")
    assert "load_nm outside 4 to 20 N·m" in (loaded.next_measurement or "")


@pytest.mark.large
def test_the_adopted_file_has_the_column_and_its_zero(loaded: Diagnosis, tmp_path: Path) -> None:
    assert loaded.described is not None
    product = loaded.described.effect
    assert isinstance(product, ProductOfParts)
    adopt(product, "loaded_lobes", loaded.description or "", tmp_path)
    adopted = catalogue([tmp_path])["loaded_lobes"]()
    assert isinstance(adopted, ProductOfParts)
    assert adopted.condition.column_zero == pytest.approx(12.0, abs=1.0)
    solution = fit([_base(), Term(adopted, {})], observations_of(_loaded()))
    assert solution.parameters()[-1]["amplitude"].value == pytest.approx(
        LOBES_ARCSEC_PER_NM, rel=0.05
    )
    without = observations_of(measurement_set())
    assert adopted.missing(without) == ["the column load_nm"]


def test_compare_bins_the_residual_by_every_column() -> None:
    """The comparison bins the residual by every column: the error of the reference grows by 0.02″
    per degree of the column elevation, and the other column has no influence."""
    random = np.random.default_rng(3)
    size = 720
    target = np.arange(size) * 0.5
    elevation = random.uniform(15.0, 65.0, size)
    error = 5.0 * np.cos(np.radians(target)) + 0.02 * elevation + random.normal(0.0, 0.1, size)
    measurement = MeasurementSet(
        Table(),
        None,
        Reference(
            target_deg=target,
            error_arcsec=error,
            conditions={"elevation_deg": elevation, "current_a": random.normal(0.0, 1.0, size)},
        ),
        title="elevation",
    )
    seen = compare(fit([_base()], observations_of(measurement)), seed=1)
    share = {item.condition: item.excess_share for item in seen.maps}
    assert share["elevation_deg"] > 0.5
    assert share["current_a"] < 0.05
    unit = next(item.unit for item in seen.maps if item.condition == "elevation_deg")
    assert unit == "deg"
    assert seen.findings[0].follows in ("elevation_deg", "(elevation_deg − 40)")


@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.large)])
def test_a_torque_that_repeats_with_the_angle_is_described_by_its_column(seed: int) -> None:
    """An arm with a payload twists by 1.2″/N·m; its torque is payload × sin θ. Six runs over 36
    stations have payloads of 0, 0, 10, 10, 20 and 20 N·m, which also grow with the time. The disc's
    order 1 cancels half of the mean twist, so that the twist exceeds the measured error."""
    random = np.random.default_rng(seed)
    run = np.repeat(np.arange(6), 36)
    target = np.tile(np.arange(36) * 10.0, 6)
    payload_nm = np.array([0.0, 0.0, 10.0, 10.0, 20.0, 20.0])
    load = payload_nm[run] * np.sin(np.radians(target))
    disc = -6.0 * np.sin(np.radians(target)) + np.cos(np.radians(2.0 * target))
    error = disc + 1.2 * load
    assert float(np.std(1.2 * load)) > float(np.std(error))
    reference = Reference(
        target_deg=target,
        error_arcsec=error + random.normal(0.0, 1.0, run.size),
        run=run,
        time_s=5.0 * np.arange(run.size) + 30.0 * run,
        direction=np.ones(run.size, dtype=np.int64),
        conditions={"load_nm": load},
    )
    found = diagnose(observations_of(MeasurementSet(Table(), None, reference)), [_base()], EFFECTS)
    assert found.described is not None
    assert found.described.effect.parts == ["load_nm", "reference"]
    # White noise of 1″: u is 1″ divided by the root of a sum of squares, that of the part of the
    # column that the model does not explain. This part is 40 % of sum(load²), which is
    # 216 · 83 N²m².
    size = found.described.parameters()["size"]
    assert size.value == pytest.approx(1.2, abs=4.0 / np.sqrt(0.4 * 216 * 83))
    assert "load_nm outside −20 to 20 N·m" in (found.next_measurement or "")


@pytest.mark.parametrize(
    ("column", "unit"),
    [("load_nm", "N·m"), ("elevation_deg", "deg"), ("humidity", "[humidity]"), ("a", "[a]")],
)
def test_the_unit_of_a_column_is_the_end_of_its_name(column: str, unit: str) -> None:
    assert column_unit(column) == unit
