"""Tests the solution of a multi-step test: an error of a part that is turned between the runs."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.workbench.diagnose.adopted import adopt
from arctrue.workbench.diagnose.turned import turned_products
from arctrue.workbench.effects.product_of_parts import ProductOfParts
from arctrue.workbench.effects.registry import catalogue
from arctrue.workbench.observations.build import observations_of
from tests.workbench.base_diagnosis import diagnosis_of

Float = NDArray[np.float64]


def _turned(
    errors: Float, runs: int, noise: float, seed: int, sign: int = 1, mount: Float | None = None
) -> MeasurementSet:
    """Return one run per mounting, over as many stations as ``errors`` has values. These are the
    errors of the places of a part, which is turned by one more station before each run."""
    random = np.random.default_rng(seed)
    stations = errors.size
    run = np.repeat(np.arange(runs), stations)
    place = np.tile(np.arange(stations), runs)
    target = place * 360.0 / stations
    angle = np.radians(target)
    table = 5.0 * np.cos(angle + 0.4) + np.cos(2.0 * angle) + 0.5 * np.cos(3.0 * angle + 1.0)
    turned = run if mount is None else mount[run]
    error = table + errors[(place + sign * turned) % stations]
    reference = Reference(
        target,
        error + random.normal(0.0, noise, run.size),
        run=run,
        time_s=5.0 * np.arange(run.size) + random.uniform(-0.5, 0.5, run.size) + 30.0 * run,
        direction=np.ones(run.size),
        conditions={"mount_deg": turned * 360.0 / stations},
    )
    return MeasurementSet(Table(), None, reference)


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("sign", [1, -1])
def test_an_eccentric_gauge_is_found_by_its_mounting(seed: int, sign: int, tmp_path: Path) -> None:
    """With 0.1″ of noise at 12 × 12 stations, u of an amplitude is 0.1″ · √(2/144) = 0.012″; the
    bound is six times u."""
    errors = 1.5 * np.cos(2.0 * np.pi * np.arange(12) / 12 + 1.0)
    found = diagnosis_of(_turned(errors, 12, 0.1, seed, sign))
    assert found.verdict == "unknown"
    assert found.described is not None
    effect = found.described.effect
    assert isinstance(effect, ProductOfParts)
    assert effect.parts == ["order:1", f"turned:{'-' if sign < 0 else ''}mount_deg", "reference"]
    amplitude = found.described.parameters()["amplitude"].value
    assert amplitude == pytest.approx(1.5, abs=0.072)
    moves = "target_deg + mount_deg" if sign > 0 else "target_deg − mount_deg"
    assert moves in (found.description or "")
    adopt(effect, "gauge", found.description or "", tmp_path)
    again = catalogue([tmp_path])["gauge"]()
    assert isinstance(again, ProductOfParts)
    assert again.parts == effect.parts


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_faces_of_a_polygon_are_found_by_its_mounting(seed: int) -> None:
    """The orders 1 to 6 describe all errors of 12 faces without their mean. No line remains.

    Only the six mountings m separate the orders of the polygon from those of the table's model. For
    an order n, the mean of exp(i n m) over the mountings is at most 0.64, so that u is at most
    0.06″ · √(2/72/(1 − 0.64²)) = 0.013″. Eleven such errors change the RMS, which has two digits,
    by less than 0.04″.
    """
    bound = 0.045
    errors = np.random.default_rng(100 + seed).normal(0.0, 0.4, 12)
    true = float(np.std(errors))
    found = diagnosis_of(_turned(errors, 6, 0.06, seed))
    assert found.verdict == "unknown"
    assert found.described is not None
    assert "orders 1 to 6 of target_deg + mount_deg" in (found.description or "")
    rms = float((found.description or "").rpartition(", ")[2].partition("″")[0])
    assert rms == pytest.approx(true, abs=bound)
    assert found.decision.further is None or found.decision.further.verdict == "adequate"


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_perfect_part_is_not_described(seed: int) -> None:
    assert diagnosis_of(_turned(np.zeros(12), 12, 0.1, seed)).described is None


def test_which_columns_turn_a_part() -> None:
    errors = np.zeros(12)
    made = observations_of(_turned(errors, 6, 0.1, 1))
    # Orders 1 to 6 alone and together, with both signs.
    assert len(turned_products(made)) == 14
    whole_turns = 12 * np.arange(6)
    assert not turned_products(observations_of(_turned(errors, 6, 0.1, 1, mount=whole_turns)))
    parts = 0.3 * np.arange(6)
    rows = made.reference
    assert rows is not None
    between = replace(rows, conditions={"mount_deg": parts[rows.run]})
    assert not turned_products(replace(made, reference=between))
    within = replace(rows, conditions={"elevation_deg": np.degrees(rows.target_rad)})
    assert not turned_products(replace(made, reference=within))


def test_no_column_turns_a_part_of_a_log_on_the_move() -> None:
    """Rows 0.018° apart have no pitch by which a part could have been turned."""
    rows = 20_000
    run = np.repeat(np.arange(4), rows // 4)
    log = Reference(
        np.arange(rows) * 0.018,
        np.zeros(rows),
        run=run,
        time_s=0.1 * np.arange(rows),
        conditions={"tilt_deg": np.array([0.0, 0.7, 1.9, 0.4])[run]},
    )
    assert turned_products(observations_of(MeasurementSet(Table(), None, log))) == []
