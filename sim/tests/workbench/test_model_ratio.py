"""Tests of the likelihood ratio of two models, and of the number of their parameters."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from sim.tests.workbench.small_sets import measurement_set, paper_error

import arctrue
from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.every_row import on_every_row
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.model_ratio import model_ratio
from arctrue.workbench.inference.solution import Solution
from arctrue.workbench.observations import Observations, part
from arctrue.workbench.observations.build import observations_of

EFFECTS = built_in()
LINE_ORDER, FREQUENCY_HZ = 37.43, 0.21
LINE = {"order": LINE_ORDER, "frequency": 0.0, "in_time": 0.0, "in_capture": 0.0}
IN_TIME = {"order": 0.0, "frequency": FREQUENCY_HZ, "in_time": 1.0, "in_capture": 0.0}
GRADUATION = Term(EFFECTS["graduation_harmonics"](), {})


@cache
def _observations() -> Observations:
    """Return a pass of one turn with a line of order 37.43, 0.3″ in noise of 0.2″."""
    target = np.arange(360.0)
    noise = np.random.default_rng(4).normal(0.0, 0.2, target.size)
    error = np.cos(np.radians(target)) + 0.3 * np.cos(LINE_ORDER * np.radians(target)) + noise
    reference = Reference(target_deg=target, error_arcsec=error, time_s=0.5 * target)
    return observations_of(MeasurementSet(Table(), None, reference, title="one line"))


@cache
def _fitted(*effects: tuple[str, tuple[tuple[str, float], ...]]) -> Solution:
    terms = [Term(EFFECTS[name](), dict(place)) for name, place in effects]
    return fit([GRADUATION, *terms], _observations())


@pytest.mark.parametrize("place", [LINE, IN_TIME])
def test_a_line_has_an_amplitude_a_phase_and_one_rate(place: dict[str, float]) -> None:
    """A line has three parameters: its order or its frequency, and two coefficients. Its channel,
    and the choice between angle and time, are no parameters."""
    small, large = _fitted(), _fitted(("periodic_error", tuple(place.items())))
    found = model_ratio(small, large)
    assert found is not None
    assert found.parameters == 3
    parameters = small.rank + 3
    likelihood, rows = large.log_likelihood, _observations().rows
    assert large.bic == pytest.approx(parameters * np.log(rows) - 2.0 * likelihood, rel=1e-12)


@pytest.mark.parametrize(
    ("name", "place", "searched"),
    [
        ("graduation_defect", {"place": 40.0, "width": 1.0}, 2),
        ("vibration", {"frequency": 3.0}, 1),
        ("bearing_ball_pass", {"order": 4.7}, 1),
        ("count_slip", {"run": 0.0, "instant": 1.0}, 2),
        ("high_order_graduation", {"order": 41.0}, 1),
        ("hysteresis", {}, 0),
    ],
)
def test_each_other_search_parameter_counts(
    name: str, place: dict[str, float], searched: int
) -> None:
    assert Term(EFFECTS[name](), place).searched == searched


def test_akaikes_criterion_counts_a_line_as_three_parameters() -> None:
    table = _observations().reference
    assert table is not None
    data = arctrue.Dataset.from_arrays(
        reference={
            "target_deg": np.degrees(table.target_rad),
            "error_arcsec": table.error_arcsec,
            "time_s": table.time_s,
        }
    )
    orders = {"orders": [1]}
    model = arctrue.Model().having(graduation_harmonics=orders).having("periodic_error")
    found = arctrue.fit(data, model)
    # The parameters are the constant, the two of order 1, and amplitude, phase and order of the
    # line.
    assert found.aic == pytest.approx(2.0 * 6.0 - 2.0 * found.log_likelihood, rel=1e-12)


def test_a_part_of_the_rows_shows_an_effect_as_all_rows_do(monkeypatch: pytest.MonkeyPatch) -> None:
    """The gain of an effect follows from the rows that the statistics use, although a long capture
    is fitted to every row: rows·log(RSS without/RSS with), from least squares over these rows.

    The limit of 150,000 rows is lowered to 5,000 of the 9,600 rows.
    """
    monkeypatch.setattr(part, "MOST_ROWS", 5_000)
    measured = measurement_set(
        lambda disc, warm, speed: paper_error(disc, warm, speed) + 0.03 * np.cos(41.0 * disc),
        turns=2,
        reference=False,
    )
    observations = observations_of(measured)
    rows = observations.capture
    assert rows is not None
    assert observations.stored is not None
    line = Term(EFFECTS["high_order_graduation"](), {"order": 41.0})
    small, large = (
        on_every_row(fit(terms, observations)) for terms in ([GRADUATION], [GRADUATION, line])
    )
    assert small.every_row
    found = model_ratio(small, large)
    assert found is not None
    waves = [
        function(order * rows.disc2_rad) - function(order * rows.disc1_rad)
        for order in (*range(1, 21), 41)
        for function in (np.cos, np.sin)
    ]
    design = np.stack([*waves, *(rows.run == run for run in range(rows.runs))], axis=1)
    least = [
        np.linalg.lstsq(columns, rows.difference_arcsec)[1][0]
        for columns in (np.delete(design, [40, 41], axis=1), design)
    ]
    # The line is a fifth of the noise of a row, so that slow noise cannot explain it in the small
    # model: of a line of 0.05″, slow noise would take 16 % of the gain.
    expected = rows.run.size * np.log(least[0] / least[1])
    assert expected > 100.0
    assert found.gain == pytest.approx(expected, rel=0.1)
    assert found.p_value < 1e-9
