"""Tests of the forward search, which adds lines (sine waves) to the model one after another, on
logs that are computed from the physics."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Literal

import numpy as np
import pytest

from arctrue.workbench.inference.forward.record import (
    MANY_RATES,
    MOST_ROWS,
    Record,
    record_of,
)
from arctrue.workbench.inference.forward.scan_of_rates import own_shares
from arctrue.workbench.inference.forward.search import LineSearch, search_lines
from arctrue.workbench.inference.forward.tests_of_a_line import coherence
from arctrue.workbench.noise import kernel_fit
from arctrue.workbench.noise.kernel import (
    IMPOSSIBLE,
    KernelFactor,
    KernelNoise,
    Part,
    with_slopes,
)
from tests.workbench.noisy_logs import NULLS, clock, ornstein_uhlenbeck, with_lines

WORM_S = 478.0
MOUNT = [(8.5, WORM_S), (4.3, 180.3), (1.8, 71.9), (0.8, 43.1)]
"""Lines of a mount, each with amplitude (arcsec) and period (s): its worm, and the gears in front
of it."""
HOUR_S = 3600.0
SAME_AMPLITUDE = 0.25
"""Relative tolerance of an amplitude.

The standard uncertainty of an amplitude is √(2·2τσ²/T) = 0.21″, in Ornstein–Uhlenbeck noise of 0.9″
and 25 s over half an hour. The tolerance of the line of 1.8″ is 0.45″; the line of 0.8″ is not
compared.
"""


def _record(time_s: np.ndarray, error: np.ndarray, declared_s: float | None = None) -> Record:
    return record_of(
        time_s,
        time_s,
        np.zeros(time_s.size, dtype=np.int64),
        error - error.mean(),
        np.zeros((time_s.size, 0)),
        in_time=True,
        declared=None if declared_s is None else 1.0 / declared_s,
    )


def _periods(found: LineSearch) -> list[float]:
    return [1.0 / line.rate for line in found.lines]


def _mount(seed: int, rows: int = 3000, step_s: float = 0.65) -> tuple[np.ndarray, np.ndarray]:
    random = np.random.default_rng(seed)
    time_s = clock(random, rows, step_s, "jitter")
    noise = 0.9 * ornstein_uhlenbeck(random, time_s, 25.0) + 0.6 * random.normal(size=rows)
    return time_s, with_lines(time_s, MOUNT) + noise


@pytest.mark.parametrize(
    "size_arcsec",
    [
        pytest.param(3.0, marks=pytest.mark.large),
        pytest.param(40.0, marks=pytest.mark.large),
        400.0,
    ],
)
def test_a_rate_is_known_to_its_own_uncertainty(size_arcsec: float) -> None:
    """A sine in white noise has σ_f = √6·σ/(π·T·A·√N) (Rife and Boorstyn, IEEE Trans. Inf. Theory
    20 (1974) 591): the frequency of a line of 400 σ is known to 5·10⁻⁵ of 1/T."""
    random = np.random.default_rng(11)
    rows, step_s, rate = 1500, 0.4, 0.0731
    time_s = np.arange(rows) * step_s
    error = size_arcsec * np.cos(2.0 * np.pi * rate * time_s + 1.0) + random.normal(size=rows)
    found = search_lines(_record(time_s, error)).lines
    sigma = np.sqrt(6.0) / (np.pi * rows * step_s * size_arcsec * np.sqrt(rows))
    assert found[0].rate == pytest.approx(rate, abs=4.0 * sigma)


@pytest.mark.large
@pytest.mark.parametrize("seed", [1, 2])
def test_the_largest_line_of_a_mount_is_first(seed: int) -> None:
    """The search finds the three largest of the mount's four lines in the order of their size; the
    log has four periods of the worm."""
    time_s, error = _mount(seed)
    found = search_lines(_record(time_s, error, declared_s=WORM_S))
    periods = _periods(found)
    assert periods[:3] == pytest.approx([478.0, 180.3, 71.9], rel=0.02)
    amplitudes = [line.amplitude_arcsec for line in found.lines[:3]]
    assert amplitudes == pytest.approx([8.5, 4.3, 1.8], rel=SAME_AMPLITUDE)
    assert found.lines[0].multiple == 1
    # The search finds only lines of the mount.
    assert all(min(abs(period / own - 1.0) for _, own in MOUNT) < 0.02 for period in periods)


def test_three_periods_are_a_line_only_where_the_period_is_declared() -> None:
    random = np.random.default_rng(3)
    time_s = clock(random, 1500, 1.0, "even")
    error = 6.0 * np.sin(2.0 * np.pi * time_s / 450.0) + random.normal(size=time_s.size)
    assert search_lines(_record(time_s, error)).lines == ()
    declared = search_lines(_record(time_s, error, declared_s=450.0)).lines
    assert [1.0 / line.rate for line in declared] == pytest.approx([450.0], rel=0.01)


@pytest.mark.parametrize(
    ("lines", "multiples"),
    [
        # The line of 157.5 s is 0.25 of 1/T from the worm's third multiple, 159.3 s, in a log of
        # seven worm periods.
        ([(3.0, 157.5)], [None]),
        pytest.param([(6.0, WORM_S), (3.0, 157.5)], [1, None], marks=pytest.mark.large),
        pytest.param([(6.0, WORM_S), (3.0, WORM_S / 3.0)], [1, 3], marks=pytest.mark.large),
        # A gear of which only the third multiple exists: this rate is exact.
        pytest.param([(3.0, WORM_S / 3.0)], [3], marks=pytest.mark.large),
    ],
)
def test_a_line_is_a_multiple_only_within_its_uncertainty(
    lines: list[tuple[float, float]], multiples: list[int | None]
) -> None:
    """A line near a multiple of the worm belongs to the worm only if its own rate agrees with the
    multiple within its uncertainty. In white noise of 1″ the standard uncertainty √6·σ/(π·T·A·√N)
    would be 0.007 of 1/T (Rife and Boorstyn, as above); in this coloured noise it is about 0.03 of
    1/T."""
    random = np.random.default_rng(21)
    time_s = clock(random, 1400, 2.4, "jitter")
    noise = 0.6 * ornstein_uhlenbeck(random, time_s, 60.0) + 0.8 * random.normal(size=1400)
    found = search_lines(_record(time_s, with_lines(time_s, lines) + noise, declared_s=WORM_S))
    assert _periods(found)[: len(lines)] == pytest.approx([one for _, one in lines], rel=0.01)
    assert [line.multiple for line in found.lines[: len(lines)]] == multiples


def test_a_line_that_is_there_in_half_of_the_log_is_none() -> None:
    """The search finds no line in an oscillation that lasts for only a part of the log, because the
    other blocks do not predict it."""
    random = np.random.default_rng(4)
    time_s = clock(random, 1600, 1.0, "even")
    ringing = np.where(time_s < 500.0, 2.0 * np.sin(2.0 * np.pi * time_s / 50.0), 0.0)
    error = ringing + ornstein_uhlenbeck(random, time_s, 20.0)
    found = search_lines(_record(time_s, error))
    assert found.lines == ()
    assert any(abs(item.rate * 50.0 - 1.0) < 0.05 for item in found.rejected)


FURTHER_NULLS = (
    "OU 30 s",
    "OU 20 s and 400 s",
    "critically damped 60 s",
    "moving mean of 12",
    "resonance 90 s, Q 4",
    "resonance 120 s, Q 15",
)
"""Kinds of noise that only ``make test-large`` runs; the search takes longest in them."""


@pytest.mark.parametrize(
    "kind",
    [pytest.param(kind, marks=[pytest.mark.large] * (kind in FURTHER_NULLS)) for kind in NULLS],
)
def test_noise_shows_no_line(kind: str) -> None:
    """The search finds no line in one log of each kind of noise; ``scripts.calibrate_line_search``
    searches many logs."""
    random = np.random.default_rng((7, list(NULLS).index(kind)))
    time_s = clock(random, 900, 4.0, "jitter")
    assert _periods(search_lines(_record(time_s, NULLS[kind](random, time_s)))) == []


@pytest.mark.parametrize(
    ("kind", "rows", "orders", "number"),
    [
        pytest.param("walk, t with 3 degrees", 600, 20, 7, marks=pytest.mark.large),
        pytest.param("smooth 1/f^3", 600, 20, 6, marks=pytest.mark.large),
        pytest.param("moving mean of 12", 600, 20, 0, marks=pytest.mark.large),
        pytest.param("walk, t with 2 degrees", 300, 6, 0, marks=pytest.mark.large),
        ("smooth 1/f^3", 300, 6, 6),
    ],
)
def test_noise_shows_no_line_next_to_the_orders_of_the_model(
    kind: str, rows: int, orders: int, number: int
) -> None:
    """The search finds no line in noise, in a log of 0.95 turns in which the orders of the model
    have absorbed the noise of lower frequencies."""
    random = np.random.default_rng((777, list(NULLS).index(kind), number, rows))
    time_s = clock(random, rows, HOUR_S / rows, ("even", "jitter", "pause")[number % 3])
    error = NULLS[kind](random, time_s)
    waves = np.outer(np.arange(rows) * (0.95 * 2.0 * np.pi / rows), np.arange(1, orders + 1))
    columns = np.hstack([np.cos(waves), np.sin(waves)])
    record = record_of(time_s, time_s, np.zeros(rows, dtype=np.int64), error, columns, in_time=True)
    assert search_lines(record).lines == ()


@pytest.mark.large
def test_a_long_log_is_averaged_before_the_search() -> None:
    random = np.random.default_rng(5)
    time_s = np.arange(72_000) * (HOUR_S / 72_000)
    coarse = time_s[::20]
    slow = np.interp(time_s, coarse, ornstein_uhlenbeck(random, coarse, 30.0))
    error = with_lines(time_s, MOUNT) + slow + random.normal(size=time_s.size)
    record = _record(time_s, error, declared_s=WORM_S)
    found = search_lines(record)
    assert record.clock.size <= MOST_ROWS
    assert _periods(found)[:4] == pytest.approx([478.0, 180.3, 71.9, 43.1], rel=0.02)


def test_averaged_rows_keep_the_amplitude_of_a_short_period() -> None:
    """Averaging multiplies the amplitude by sinc(1/6) = 0.955 with six averaged rows per period;
    the columns contain this factor."""
    time_s = np.arange(8000) * 0.5
    record = _record(time_s, np.cos(2.0 * np.pi * time_s / 15.0))
    columns = record.line_columns(1.0 / 15.0)
    fitted = np.linalg.lstsq(columns, record.residual_arcsec, rcond=None)[0]
    assert float(np.hypot(*fitted)) == pytest.approx(1.0, abs=0.002)


@pytest.mark.parametrize(
    "parts",
    [
        (),
        (Part("exponential", 0.5, 30.0),),
        (Part("exponential", 0.5, 30.0), Part("smooth", 0.7, 10.0)),
        (Part("exponential", 0.4, 9.0), Part("oscillator", 0.6, 40.0, 0.02)),
        (Part("smooth", 0.4, 9.0), Part("oscillator", 0.6, 40.0, 0.02), Part("exponential", 2, 5)),
    ],
    ids=lambda parts: " ".join(part.kind for part in parts) or "white",
)
def test_likelihood_and_slopes_of_a_kernel(parts: tuple[Part, ...]) -> None:
    """The kernel's likelihood equals that of the complete covariance matrix with its determinant,
    and its slopes equal differences of the likelihood."""
    random = np.random.default_rng(6)
    clock_s = np.sort(random.uniform(0.0, 300.0, 240))
    readings = random.integers(1, 4, clock_s.size).astype(np.float64)
    values = np.column_stack([random.normal(size=clock_s.size), np.ones(clock_s.size), clock_s])
    noise = KernelNoise(0.3, parts)

    def written_out(of: KernelNoise) -> float:
        apart = np.abs(clock_s[:, np.newaxis] - clock_s)
        whole = np.diag(of.white / readings)
        for part in of.parts:
            x = apart / part.decay
            shape = np.exp(-x)
            if part.kind == "smooth":
                shape = (1.0 + x) * shape
            elif part.kind == "oscillator":
                turn = 2.0 * np.pi * part.frequency
                shape = shape * (np.cos(turn * apart) + np.sin(turn * apart) / (turn * part.decay))
            whole = whole + part.variance * shape
        precise = np.linalg.inv(whole)
        columns, own = values[:, 1:], values[:, 0]
        best = np.linalg.solve(columns.T @ precise @ columns, columns.T @ precise @ own)
        left = own - columns @ best
        return -0.5 * float(left @ precise @ left + np.linalg.slogdet(whole)[1])

    value, slopes = with_slopes(clock_s, readings, values, noise, range(noise.logs.size))
    # Smooth noise is approximated by two exponentials whose rates are 1.1·λ and λ/1.1, to 0.003 of
    # its variance.
    nearly = 1e-3 if noise.smooth else 1e-9
    assert value == pytest.approx(written_out(noise), rel=nearly)
    for index, slope in enumerate(slopes):
        moved = np.zeros(slopes.size)
        moved[index] = 1e-4
        there, here = (written_out(noise.with_logs(noise.logs + sign * moved)) for sign in (1, -1))
        assert slope == pytest.approx((there - here) / 2e-4, rel=0.02, abs=0.02)


@pytest.mark.parametrize("parts", [("exponential",), ("exponential", "smooth", "oscillator")])
def test_noise_that_cannot_be_factored_is_impossible(parts: tuple[Literal["smooth"], ...]) -> None:
    """A negative variance of the rows is impossible, with derivatives of either kind."""
    noise = KernelNoise(-9.0, tuple(Part(kind, 1.0, 5.0, 0.05) for kind in parts))
    rows = np.arange(6.0)
    value, slopes = with_slopes(rows, np.ones(6), np.ones((6, 1)), noise, range(3))
    assert value == IMPOSSIBLE
    assert not slopes.any()


def test_a_second_search_of_a_record_fits_no_noise_again(monkeypatch: pytest.MonkeyPatch) -> None:
    """A second search of equal numbers evaluates no likelihood; a search after one number has
    changed does."""
    asked = []

    def counted(*of: Any) -> tuple[float, np.ndarray]:
        asked.append(of)
        return with_slopes(*of)

    monkeypatch.setattr(kernel_fit, "with_slopes", counted)
    time_s, error = _mount(41, rows=300)
    first = search_lines(_record(time_s, error))
    number = len(asked)
    assert number > 0
    assert search_lines(_record(time_s, error)).noise == first.noise
    assert len(asked) == number
    error[0] += 1e-6
    search_lines(_record(time_s, error))
    assert len(asked) > number


def test_columns_of_a_grid_are_kept_until_they_are_released() -> None:
    """The columns of a grid are calculated once. They equal cos and sin of 2π·rate·time, because
    single rows are not averaged. The search releases them."""
    time_s, error = _mount(42, rows=300)
    record = _record(time_s, error)
    rates = np.linspace(0.01, 0.1, MANY_RATES)
    columns = record.columns(rates)
    assert record.columns(rates.copy()) is columns
    assert record.columns(rates + 1e-3) is not columns
    phase = 2.0 * np.pi * np.outer(time_s - time_s[0], rates)
    assert columns[:, ::2] == pytest.approx(np.cos(phase), abs=1e-12)
    assert columns[:, 1::2] == pytest.approx(np.sin(phase), abs=1e-12)
    search_lines(record)
    assert record.columns(rates) is not columns


def test_drawn_kernel_noise_has_its_covariance() -> None:
    """The covariance of 4,000 draws agrees with the stated covariance within 5 standard
    uncertainties, each √(2/4000) of a variance."""
    clock_s = np.array([0.0, 3.0, 10.0])
    noise = KernelNoise(0.1, (Part("oscillator", 1.0, 20.0, 0.05),))
    factor = KernelFactor(clock_s, np.ones(3), noise)
    random = np.random.default_rng(8)
    drawn = np.array([factor.colour(random.normal(size=3)) for _ in range(4000)])
    turn = 2.0 * np.pi * 0.05
    apart = np.abs(clock_s[:, np.newaxis] - clock_s)
    shape = np.exp(-apart / 20.0) * (np.cos(turn * apart) + np.sin(turn * apart) / (20.0 * turn))
    expected = shape + 0.1 * np.eye(3)
    assert np.cov(drawn.T) == pytest.approx(expected, abs=5.0 * np.sqrt(2.0 / 4000.0) * 1.1)


def _on_an_arc(turns: float, rows: int, lines: list[tuple[float, float]], noise: float) -> Record:
    """Return a log over a number of turns; the model has the table's 20 orders."""
    random = np.random.default_rng(5)
    place = turns * np.arange(rows) / rows
    error = noise * random.normal(size=rows)
    error += sum(size * np.cos(2.0 * np.pi * order * place + 1.0) for size, order in lines)
    phase = 2.0 * np.pi * np.outer(place, np.arange(1, 21))
    orders = np.hstack([np.cos(phase), np.sin(phase)])
    base = np.column_stack([np.ones(rows), orders])
    left = error - base @ np.linalg.lstsq(base, error, rcond=1e-9)[0]
    one = np.zeros(rows, dtype=np.int64)
    return record_of(np.arange(rows) * 1.0, place, one, left, orders, in_time=False)


def test_what_the_orders_of_an_arc_leave_is_no_larger_than_it_is() -> None:
    """A line on an arc is not stated larger than the residual: on 0.3 of a turn, 20 orders absorb
    all but a fourth of the amplitude of order 25.

    A line of order 25 that is fitted together with these orders would have four times the amplitude
    of the residual, and most of it would cancel against the other orders.
    """
    record = _on_an_arc(0.3, 400, [], 1.0)
    line = record.columns(np.array([25.0]))
    assert own_shares(record, line)[0] < 0.1
    left = line[:, 0] - record.base @ (record.base.T @ line[:, 0])
    seen = left * 6.0 / np.linalg.norm(left)
    found = search_lines(replace(record, residual_arcsec=record.residual_arcsec + seen))
    # The RMS is 6/√400 = 0.3″; the bound is twice the amplitude of a steady wave with this RMS.
    assert all(one.amplitude_arcsec < 2.0 * np.sqrt(2.0) * 6.0 / 20.0 for one in found.lines)
    # A line of order 90, which the model does not describe, is found.
    far = record.columns(np.array([90.0]))[:, 0]
    seen = far * 8.0 / np.linalg.norm(far)
    shown = replace(record, residual_arcsec=record.residual_arcsec + seen)
    assert [one.rate for one in search_lines(shown).lines] == pytest.approx([90.0], rel=0.02)


def test_a_line_between_two_orders_is_found() -> None:
    """The search finds order 6.5 between two orders of the model: on 1.3 turns the orders describe
    half of it, and the residual is still far above the noise."""
    record = _on_an_arc(1.3, 300, [(30.0, 6.5)], 1.0)
    lines = search_lines(record).lines
    assert lines[0].rate == pytest.approx(6.5, abs=0.1)
    assert lines[0].amplitude_arcsec == pytest.approx(30.0, rel=0.1)


def test_a_line_takes_no_more_than_there_is() -> None:
    """The blocks test only the part of a line that the model's orders do not explain, and not a
    part that these orders would cancel."""
    record = _on_an_arc(1.3, 400, [(10.0, 6.5)], 1.0)
    columns = record.columns(np.array([6.5]))
    noise = KernelNoise(1.0)
    found = coherence(record, columns, np.zeros((record.clock.size, 0)), noise, 8.0)
    left = float(np.sqrt(np.mean(record.residual_arcsec**2)))
    assert found.taken_arcsec < left
