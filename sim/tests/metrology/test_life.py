"""Tests that the detected changes of a parameter over time and the forecasts of the parameter agree
with an exhaustive search and with simulated truth."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import stats

from arctrue.metrology.life.change import (
    basis,
    find_changes,
    largest_tail,
    look_probability,
    places,
    ratios,
    weights,
)
from arctrue.metrology.life.forecast import forecast
from arctrue.metrology.life.series import Series, series_of
from arctrue.studies.life.judge import run_lives, share_interval, summary, tasks
from arctrue.workbench.effects.base import Parameter, amplitude_and_phase

Float = NDArray[np.float64]

WEEK = 7.0
SURE = 1e-3
"""Probability that a correct program fails one of the tests that count random cases."""


def a_series(values: Float, u: float = 0.03, name: str = "effect.size") -> Series:
    days = np.arange(values.shape[0]) * WEEK
    return Series(name, "arcsec", days, values, np.full(values.shape[0], u))


def test_the_ratio_is_that_of_least_squares() -> None:
    random = np.random.default_rng(1)
    days = np.cumsum(random.uniform(5.0, 20.0, 11))
    values, weight = random.standard_normal((11, 2)), random.uniform(0.5, 2.0, 11)
    root = np.sqrt(weight)[:, None]

    def rss(design: Float) -> float:
        return float(np.linalg.lstsq(root * design, root * values, rcond=None)[1].sum())

    constant = np.ones((11, 1))
    brute = max(
        22.0 * np.log(rss(constant) / rss(np.column_stack([constant, basis(days, *place)])))
        for place in places(days)
    )
    assert ratios(days, weight[None], values[None])[0] == pytest.approx(brute, rel=1e-9)


def test_the_scatter_between_sets_solves_its_equation() -> None:
    random = np.random.default_rng(2)
    u = random.uniform(0.01, 0.1, 400)
    values = (0.2 * random.standard_normal(400) + u * random.standard_normal(400))[:, None]
    weight = weights(values, u, np.ones((400, 1)))
    scatter = np.sqrt(1.0 / weight - u**2)
    np.testing.assert_allclose(scatter, scatter[0], rtol=1e-6)
    # The tolerance is four standard deviations of an estimated standard deviation, each 0.2/√800.
    assert scatter[0] == pytest.approx(0.2, abs=4.0 * 0.2 / np.sqrt(800.0))
    within = weights((u * 0.1)[:, None], u, np.ones((400, 1)))
    np.testing.assert_allclose(within, 1.0 / u**2)


@pytest.mark.parametrize("parts", [1, 2])
def test_the_tail_is_an_upper_limit_of_that_of_draws(parts: int) -> None:
    """The limit is at least the share of random series whose largest ratio exceeds ``ratio``.
    Divided by the number of possible changes, the limit equals this share for a single change,
    which the test draws as a quotient of χ² variables."""
    random, number, sets = np.random.default_rng(11), 20_000, 14
    days, weight = np.arange(sets) * WEEK, random.uniform(0.5, 2.0, sets)
    drawn = random.standard_normal((number, sets, parts)) / np.sqrt(weight)[:, None]
    found = ratios(days, weight[None], drawn)
    taken = random.chisquare(parts, 20 * number)
    rest = random.chisquare(parts * (sets - 2), 20 * number)
    one_change = parts * sets * np.log1p(taken / rest)
    for share in (0.01, 0.002):
        ratio = float(np.quantile(found, 1.0 - share))
        tail = largest_tail(ratio, days, parts)
        # Four standard deviations of a number of draws.
        assert tail > share - 4.0 * np.sqrt(share / number)
        counted = np.count_nonzero(one_change >= ratio)
        expected = 20 * number * tail / len(places(days))
        assert abs(counted - expected) < 4.0 * np.sqrt(expected) + 1.0


@pytest.mark.parametrize(("number", "gap_days"), [(30, 1.0), (5, 1.0 / 24.0)])
def test_many_series_and_short_intervals_hide_no_large_change(number: int, gap_days: float) -> None:
    """A step of 1000 standard deviations is found even if α of a series is below 1/20,000."""
    random, days = np.random.default_rng(12), np.arange(14) * gap_days
    assert look_probability(days, 0.5) / number < 1.0 / 20_000.0
    machine = []
    for place in range(number):
        values = 0.01 * random.standard_normal((14, 1))
        if place == 0:
            values[7:] += 10.0
        machine.append(Series(f"e.p{place}", "arcsec", days, values, np.full(14, 0.01)))
    found = find_changes(machine, 0.5, random)
    assert [(one.series.name, one.kind) for one in found] == [("e.p0", "step")]


DATES = np.array([0.0, 30, 60, 90, 120, 150, 180, 210, 240, 270, 300])


@pytest.mark.parametrize("again", [2, 3])
def test_a_drift_up_to_several_sets_of_one_date_is_found_and_forecast(again: int) -> None:
    """A drift of 0.01″ a day from day 150 on, measured several times on the last date, 300. A line
    through 0 at day 150 passes 2″ at day 350, 50 days after the last set."""
    random = np.random.default_rng(13)
    days = np.concatenate([DATES, np.full(again, DATES[-1])])
    true = 0.01 * np.maximum(days - 150.0, 0.0)
    values = (true + 0.01 * random.standard_normal(days.size))[:, None]
    series = Series("effect.size", "arcsec", days, values, np.full(days.size, 0.01))
    (change,) = find_changes([series], 0.5, random)
    assert change.kind == "drift"
    assert change.earliest_day <= 150.0 <= change.latest_day
    assert change.size == pytest.approx(1.5, abs=3.0 * change.u)
    found = forecast(series, [change], 2.0, random)
    # The drift may also slow down or speed up: with the time to the power ½ it passes the limit
    # at day 417, with the power 2 at day 323.
    assert 323.0 < found.day < 417.0


@pytest.mark.parametrize("days", [np.repeat(DATES[:4], 3), np.zeros(12)], ids=["three", "all"])
def test_sets_of_one_date_hide_no_large_change(days: Float) -> None:
    """A step of 1000 standard deviations is found if each date has three sets, and if all sets have
    the same date; a machine without a change has none."""
    random = np.random.default_rng(14)
    values = 0.01 * random.standard_normal((12, 1))
    series = Series("effect.size", "arcsec", days, values, np.full(12, 0.01))
    assert find_changes([series], 0.5, random) == []
    stepped = values + np.where(np.arange(12) >= 6, 10.0, 0.0)[:, None]
    series = Series("effect.size", "arcsec", days, stepped, np.full(12, 0.01))
    (change,) = find_changes([series], 0.5, random)
    assert change.earliest_day == days[5]
    assert change.latest_day == days[6]
    assert change.size == pytest.approx(10.0, abs=4.0 * change.u)


@pytest.mark.large
def test_false_findings_are_as_frequent_as_stated() -> None:
    """Machines without a change get a false finding as often as stated. Each machine has several
    parameters, which scatter more than their stated uncertainty u."""
    random, number, rate = np.random.default_rng(3), 400, 2.0
    false = 0
    for _ in range(number):
        machine = [a_series(random.standard_normal((12, 1)), name=f"e.p{i}") for i in range(4)]
        machine.append(a_series(random.standard_normal((12, 2)), name="e.amplitude"))
        false += bool(find_changes(machine, rate, random))
    alpha = look_probability(machine[0].days, rate)
    assert alpha == pytest.approx(2.0 * WEEK / 365.25)
    most = stats.binom.ppf(1.0 - SURE, number, alpha)
    least = stats.binom.ppf(SURE, number, alpha)
    assert false <= most
    # Bonferroni's bound for five independent series exceeds the true rate by less than α².
    # ``least`` shows that the true rate is not far below the stated one.
    assert false >= least


@pytest.mark.parametrize("parts", [1, pytest.param(2, marks=pytest.mark.large)])
def test_a_step_and_a_drift_are_found_with_date_and_size(parts: int) -> None:
    random, number = np.random.default_rng(4), 60
    held_day = held_size = 0
    for trial in range(number):
        kind = "step" if trial % 2 else "drift"
        shape = basis(np.arange(40) * WEEK, kind, 22)  # type: ignore[arg-type]
        true = shape[:, None] * np.full(parts, 0.5 / np.sqrt(parts))
        values = 0.3 + true + 0.05 * random.standard_normal((40, parts))
        changes = find_changes([a_series(values)], 0.5, random)
        assert changes, trial
        change = max(changes, key=lambda one: one.size)
        # A step at set 22 happened between the days of sets 21 and 22.
        day = 21.5 * WEEK if kind == "step" else 22 * WEEK
        held_day += change.earliest_day - WEEK <= day <= change.latest_day + WEEK
        held_size += abs(change.size - 0.5) < 3.0 * change.u
    assert held_day >= stats.binom.ppf(SURE, number, 0.95)
    # The size belongs to the most likely of several courses; therefore an interval of three u
    # covers only 90 % of the sizes.
    assert held_size >= stats.binom.ppf(SURE, number, 0.9)


def test_a_change_of_phase_alone_is_a_change() -> None:
    random = np.random.default_rng(5)
    covariance = np.eye(2) * 0.02**2
    found = []
    for number in range(24):
        turned = 0.0 if number < 12 else 0.5
        c, s = np.cos(turned), np.sin(turned)
        noise = 0.02 * random.standard_normal(2)
        found.append(amplitude_and_phase(c + noise[0], s + noise[1], covariance, "order_2_"))
    (one,) = series_of(np.arange(24) * WEEK, found)
    assert one.name == "order_2_amplitude"
    np.testing.assert_allclose(one.u, 0.02, rtol=1e-9)
    (change,) = find_changes([one], 0.5, random)
    assert change.kind == "step"
    # The phase changes by half a radian at the amplitude 1; the stated change is the chord of this
    # arc.
    assert change.size == pytest.approx(2.0 * np.sin(0.25), abs=4.0 * change.u)


def test_parameters_without_uncertainty_have_no_series() -> None:
    items = {
        "a.size": Parameter(1.0, 0.1, "arcsec"),
        "a.place": Parameter(2.0, float("nan"), "deg"),
        "a.phase": Parameter(2.0, 1.0, "deg"),
    }
    found = series_of(np.arange(2) * WEEK, [items, {**items, "b.new": items["a.size"]}])
    assert [one.name for one in found] == ["a.size"]


@pytest.mark.large
def test_the_interval_of_a_forecast_holds_the_day() -> None:
    """The interval of a forecast contains the day at which a drift with constant rate passes the
    limit; the size is 0.2″ until day 140, and 1″ at day 420."""
    random, number, held = np.random.default_rng(6), 60, 0
    days = np.arange(40) * WEEK
    for _ in range(number):
        true = 0.2 + 0.8 * np.maximum(days - 140.0, 0.0) / 280.0
        series = a_series((true + 0.05 * random.standard_normal(40))[:, None])
        changes = find_changes([series], 0.5, random)
        found = forecast(series, changes, 1.0, random)
        assert found.changed
        assert found.earliest_day <= found.day <= found.latest_day
        held += found.earliest_day <= 420.0 <= found.latest_day
    assert held >= stats.binom.ppf(SURE, number, 0.95)


def test_a_limit_that_is_passed_and_one_far_away() -> None:
    random = np.random.default_rng(7)
    series = a_series(0.5 + 0.02 * random.standard_normal((20, 1)))
    over = forecast(series, [], 0.4, random)
    assert over.passed
    assert over.alarm(0.0)
    under = forecast(series, [], 0.9, random)
    assert (under.day, under.latest_day) == (np.inf, np.inf)
    assert not under.alarm(1e6)


def test_fewer_than_seven_sets_show_no_change() -> None:
    values = np.array([0.0, 0.0, 0.0, 9.0, 9.0, 9.0])[:, None]
    assert find_changes([a_series(values)], 1.0, np.random.default_rng(1)) == []


@pytest.mark.large
def test_lives_have_their_alarm_in_time() -> None:
    """``life`` raises alarms in time for simulated machines, a small sample of ``python -m
    scripts.judge_life``.

    The requirement is 95 % alarms in time and one false alarm per year. ``test_life_sets.py`` tests
    single lives and their alarms.
    """
    rows = summary([run_lives(task) for task in tasks(20, 1000)])
    whole = rows[-1]
    assert whole["passing"] >= 10
    assert share_interval(whole["in_time"], whole["passing"])[1] >= 0.95
    assert whole["in_time"] >= 0.8 * whole["passing"]
    assert whole["false_alarms"] <= stats.poisson.ppf(1.0 - SURE, whole["years"])
