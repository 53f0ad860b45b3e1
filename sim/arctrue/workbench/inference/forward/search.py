"""Adds one line (a sinusoidal error) after another to the model of a record, and orders the lines
by the error that they remove.

Each step scans all rates twice: with the noise that is estimated without a further line, and with
white noise alone. White noise is needed because the estimated noise completely absorbs a line far
above the scatter of neighbouring rows. The rates with the highest gains, called places, are then
tested; for each, the noise is estimated anew without and with the line.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.inference.forward.declared_multiples import (
    factors_of,
    nearest_multiple,
    needed_at,
)
from arctrue.workbench.inference.forward.events import Step, columns_of_steps, search_steps
from arctrue.workbench.inference.forward.noise_of_record import (
    Level,
    level_of,
    noise_with,
    whiteness_of,
)
from arctrue.workbench.inference.forward.pairs import Group, group_of
from arctrue.workbench.inference.forward.places import places_of, takes_much
from arctrue.workbench.inference.forward.record import Record, orthonormal
from arctrue.workbench.inference.forward.scan_of_rates import (
    moved_in_turn,
    own_shares,
    refined,
)
from arctrue.workbench.inference.forward.tests_of_a_line import (
    DECLARED_PERIODS,
    LEAST_PERIODS,
    Coherence,
    coherence,
    gain_over_an_oscillator,
    nearest,
    periods_in,
)
from arctrue.workbench.noise.kernel import KernelNoise
from arctrue.workbench.noise.kernel_fit import KernelFit, best_fit, fit_from, usual_starts

Float = NDArray[np.float64]

MOST_LINES = 16
"""Largest number of lines, to limit cost: about three times the number of lines, five, in the
benchmark's record with the most lines.
"""
OSCILLATOR_GAIN = 7.0
"""Smallest gain in log likelihood of a line over an oscillator at its frequency. In 24 simulated
records of a resonance that keeps its phase for a sixth of the record, 65 places pass all other
tests, and no place gains more (``python -m scripts.calibrate_line_search --logs 24 --kinds Q
--oscillator``). In other noise, no place passes the other tests, or a place that passes them gains
at most 5.1."""
PREDICTED_SHARE = 0.5
"""Smallest share of a line's own error that the other blocks must predict."""
BELOW, NEXT_TO_THE_MODEL = 3, 3.0
"""Limits for a line just above the orders of a model. If fewer than BELOW ordinates of the spectrum
at lower rates are free of the model's orders, the gain of the line must be NEXT_TO_THE_MODEL times
the usual limit. Slow noise of which the model has absorbed a part looks like such a line, with a
gain of at most 2 times the limit. None of 576 simulated records of noise shows a line (``python -m
scripts.calibrate_line_search --orders --logs 4``)."""


@dataclass(frozen=True)
class Line:
    """One regular line that passed every test."""

    rate: float
    """Rate in periods per turn, or in Hz."""
    amplitude_arcsec: float
    phase_rad: float
    """Phase of the line's cosine at the first row."""
    taken_arcsec: float
    """RMS over all rows of the error that the line's prediction from other blocks removes."""
    share: float
    """Share of the line's own error that the other blocks predict; 1 for a record of one turn,
    which cannot show this share."""
    gain: float
    """Rise of the log likelihood when the line was added, with the noise estimated without and with
    it; this rise is multiplied by :func:`own_shares` and divided by the local level of the noise.
    """
    oscillator_gain: float
    periods: float
    independent: float
    """Number of independent rates among which the line was found."""
    multiple: int | None = None
    """Multiple of the declared rate; None if the line is not one of its multiples."""


@dataclass(frozen=True)
class Rejected:
    """A place with a high gain that did not pass a test."""

    rate: float
    gain: float
    why: str


@dataclass(frozen=True, eq=False)
class LineSearch:
    """Result of the forward search in one record."""

    record: Record
    lines: tuple[Line, ...]
    """Lines, ordered by the error that they remove, the largest first."""
    noise: KernelFit
    """Noise with all lines in the model."""
    whiteness_p: float
    """p of Ljung and Box for the whitened residuals with all lines and steps in the model."""
    steps: tuple[Step, ...] = ()
    """Single jumps, in the order in which they were found."""
    rejected: tuple[Rejected, ...] = field(default=(), repr=False)
    """Rejected places of the last step."""


@dataclass(frozen=True, eq=False)
class _Tried:
    rate: float
    gain: float
    oscillator_gain: float
    fit: KernelFit
    why: str | None


def search_record(record: Record, display_step_arcsec: float = 0.0) -> LineSearch:
    """Search lines, then steps with the lines in the model. If there are steps, search the lines
    again with the steps in the model.

    A display that rounds to ``display_step_arcsec`` (0 for none) jumps by this step where the error
    changes slowly. Such jumps are not events and are not returned. Together they can follow a line,
    so that the line would vanish with them in the model: the lines are searched without them. The
    whiteness of the residuals is that with these jumps or without them, whichever is higher,
    because the rounding error is not white.
    """
    found = search_lines(record)
    lines = record.columns(np.array([line.rate for line in found.lines]))
    steps = search_steps(record, lines, found.noise)
    events = [step for step in steps if not step.may_be_one(display_step_arcsec)]
    if events:
        found = search_lines(_with_steps(record, events))
    if len(events) < len(steps):
        lines = record.columns(np.array([line.rate for line in found.lines]))
        with_all = _with_steps(record, steps)
        white = whiteness_of(with_all.rows(lines), noise_with(with_all, lines).noise)
        found = replace(found, whiteness_p=max(found.whiteness_p, white))
    return replace(found, steps=tuple(events))


def _with_steps(record: Record, steps: Sequence[Step]) -> Record:
    """Return the record with the steps in its base."""
    return replace(record, base=orthonormal([record.base, columns_of_steps(record, steps)]))


def search_lines(record: Record, *, oscillator_gain: float = OSCILLATOR_GAIN) -> LineSearch:
    """Return every line that the record shows; test rejected places again after each addition.

    ``oscillator_gain`` is a parameter only for its calibration.
    """
    rates: list[float] = []
    found: list[_Tried] = []
    noise: KernelNoise | None = None
    rejected: list[Rejected] = []
    incoherent: list[_Tried] = []
    while True:
        others = record.columns(np.array(rates))
        without = noise_with(record, others, noise)
        if len(rates) >= MOST_LINES:
            break
        level = level_of(record.rows(others), without.noise)
        tried = [
            _tried(record, rate, rates, without, level)
            for rate in places_of(record, rates, without, level)
        ]
        best, rejected, incoherent = None, [], []
        for item in sorted(tried, key=lambda item: -item.gain):
            judged = item
            if item.why is None:
                judged = _judged(record, item, others, without, level, oscillator_gain)
            if judged.why is None:
                best = judged
                break
            rejected.append(Rejected(judged.rate, judged.gain, judged.why))
            if item.why is None:
                incoherent.append(item)
        if best is None:
            group = _group(record, incoherent, rates, without, level, oscillator_gain)
            if not group or len(rates) + len(group) > MOST_LINES:
                break
            found += group
            noise = group[-1].fit.noise
            rates = moved_in_turn(record, [*rates, *(one.rate for one in group)], noise)
            continue
        found.append(best)
        rates.append(best.rate)
        rates = moved_in_turn(record, rates, best.fit.noise)
        noise = best.fit.noise
    record.forget()
    return _ordered(record, rates, found, without, rejected)


def _tried(
    record: Record, rate: float, rates: Sequence[float], without: KernelFit, level: Level
) -> _Tried:
    """Return the gain of a line; the noise is estimated anew with the line in the model."""
    others = record.columns(np.array(rates))
    line = record.line_columns(rate)
    rows = record.rows(np.hstack([others, line]))
    starts = [without.noise]
    if takes_much(record, others, line):
        # A large line changes the noise so much that the noise without the line is a poor start.
        starts += usual_starts(rows)
    grown = best_fit(rows, starts)
    if not record.whole_orders_only:
        moved = refined(record, rate, others, grown.noise)
        if nearest(rates, moved) * record.span >= 1.0:
            rate, line = moved, record.line_columns(moved)
            grown = fit_from(record.rows(np.hstack([others, line])), grown.noise)
    gain = record.of_few_rows(grown.score - without.score) * float(own_shares(record, line)[0])
    gain /= level.at(record, rate)
    declared = nearest_multiple(record, rate) is not None
    tried = _Tried(rate, gain, 0.0, grown, None)
    needed = needed_at(record, rate, gain)
    if gain <= needed:
        return replace(tried, why=f"gains {gain:.1f} of {needed:.1f}")
    periods = periods_in(record, rate)
    if periods < (DECLARED_PERIODS if declared else LEAST_PERIODS):
        return replace(tried, why=f"{periods:.1f} periods")
    return tried


def _judged(
    record: Record,
    tried: _Tried,
    others: Float,
    without: KernelFit,
    level: Level,
    oscillator_gain: float,
) -> _Tried:
    """Test whether the line is the same in all blocks, and more than an oscillator driven by noise.

    Return the place with the results of the tests; ``why`` is the reason if it fails one of them,
    otherwise None.
    """
    if record.whole_orders_only:
        # Neighbouring orders cannot be separated on one turn, so that neither test applies.
        return tried
    needed = NEXT_TO_THE_MODEL * needed_at(record, tried.rate, tried.gain)
    if tried.gain < needed and level.below(record, tried.rate) < BELOW:
        return replace(tried, why=f"gains {tried.gain:.1f} of {needed:.1f} next to the model")
    rate, line = tried.rate, record.line_columns(tried.rate)
    found = coherence(record, line, others, tried.fit.noise, periods_in(record, rate))
    if found.share <= PREDICTED_SHARE:
        return replace(tried, why=f"other blocks predict {found.share:.2f} of it")
    excess = level.at(record, rate)
    with_line = gain_over_an_oscillator(
        record, line, others, rate, without, tried.fit, oscillator_gain * excess
    )
    tried = replace(tried, oscillator_gain=with_line / excess)
    if tried.oscillator_gain <= oscillator_gain:
        return replace(tried, why=f"gains {tried.oscillator_gain:.1f} over an oscillator")
    return tried


def _group(
    record: Record,
    incoherent: Sequence[_Tried],
    rates: Sequence[float],
    without: KernelFit,
    level: Level,
    oscillator_gain: float,
) -> list[_Tried]:
    """Return two or three lines next to each other, one of which fails the tests if it is tested
    alone; empty if there are none."""
    for item in () if record.whole_orders_only else incoherent:
        found = group_of(
            record,
            item.rate,
            rates,
            without,
            needed=oscillator_gain * level.at(record, item.rate),
            predicted=PREDICTED_SHARE,
        )
        lines = [] if found is None else _of_group(record, found, level)
        if lines and all(line.gain > needed_at(record, line.rate, line.gain) for line in lines):
            return lines
    return []


def _of_group(record: Record, found: Group, level: Level) -> list[_Tried]:
    """Return the lines of a group, each with its gain in the terms of :func:`_tried`."""
    lines = []
    for rate, gain, over in zip(found.rates, found.gains, found.oscillator_gains, strict=True):
        excess = level.at(record, rate)
        share = float(own_shares(record, record.line_columns(rate))[0])
        own = record.of_few_rows(gain) * share / excess
        lines.append(_Tried(rate, own, over / excess, found.fit, None))
    return lines


def _ordered(
    record: Record,
    rates: Sequence[float],
    tried: Sequence[_Tried],
    fit: KernelFit,
    rejected: Sequence[Rejected],
) -> LineSearch:
    """Return the lines, ordered by the error that they remove; the figures of each line are
    computed with all other lines in the model."""
    columns = record.columns(np.array(rates))
    rows = record.rows(columns)
    whitened = rows.factor(fit.noise).whiten(rows.values)
    found = np.linalg.lstsq(whitened[:, 1:], whitened[:, 0], rcond=1e-10)[0]
    lines = []
    multiples = factors_of(record, rates, fit.noise)
    for at, rate in enumerate(rates):
        others = record.columns(np.array([other for other in rates if other != rate]))
        line = record.line_columns(rate)
        periods = periods_in(record, rate)
        own = found[record.base.shape[1] + 2 * at :][:2]
        cosine, sine = own
        of_all = float(np.sqrt(np.mean((line @ own) ** 2)))
        seen = Coherence(1.0, of_all)
        if not record.whole_orders_only:
            # A line removes at most itself. In noise that is far slower than the line, the columns
            # contain, after the projection, a constant that is larger than the line.
            seen = coherence(record, line, others, fit.noise, periods)
            seen = replace(seen, taken_arcsec=min(seen.taken_arcsec, of_all))
        lines.append(
            Line(
                rate=rate,
                amplitude_arcsec=float(np.hypot(cosine, sine)),
                phase_rad=float(np.arctan2(-sine, cosine)),
                taken_arcsec=seen.taken_arcsec,
                share=seen.share,
                gain=tried[at].gain,
                oscillator_gain=tried[at].oscillator_gain,
                periods=periods,
                independent=record.independent,
                multiple=multiples[at],
            )
        )
    lines.sort(key=lambda line: -line.taken_arcsec)
    return LineSearch(
        record,
        tuple(lines),
        fit,
        whiteness_of(rows, fit.noise),
        rejected=tuple(rejected),
    )
