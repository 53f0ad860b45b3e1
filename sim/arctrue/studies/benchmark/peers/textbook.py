"""Defines the least-squares problem of a set, and computes the columns of most effects of the
catalogue by their textbook equations."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arctrue.base.units import ARCSEC_PER_RAD, ARCSEC_PER_TURN
from arctrue.measurement import Capture, Reference, Table, read_measurement_set

Float = NDArray[np.float64]
Whole = NDArray[np.int64]

BASE_ORDERS = 20
CHUNK = 32
"""Number of places of a search that are evaluated at once."""
BELL_WIDTHS = 5.0
"""Distance from the centre of a bell, in standard deviations, beyond which the bell is below 4e-6
of its height."""
STANDS_S = 0.5
"""Largest time between two stations that counts as motion; after a longer time the table had
stopped."""


@dataclass(frozen=True)
class Problem:
    """Values and conditions of both channels of a set, as arrays ``(n,)``; errors in arcseconds;
    empty for a missing channel."""

    difference: Float
    theta: Float
    """Reading of head 1, radians, unwrapped."""
    time_s: Float
    run: Whole
    speed: Float
    """Mean speed of the row's run, radians a second."""
    warmth_k: Float
    """Temperature minus the median temperature; empty without a temperature."""
    phases: tuple[Float, Float]
    """Electrical phase of each head, radians."""
    error: Float
    target: Float
    reference_s: Float
    reference_speed: Float
    """Speed from this station to the next one (in the last row of a pass: from the previous one); 0
    if the table stands still.
    """
    direction: Float
    face: Whole
    faces: int
    teeth: float | None
    alpha: float
    index_arcsec: float
    """Standard deviation of R₂ − R₁ from run to run that the index marks cause."""

    @property
    def runs(self) -> Whole:
        """Return the numbers of the capture's runs, each once."""
        return np.unique(self.run)

    def thinned(self, every: int) -> Problem:
        """Return the same problem with every ``every``-th row of the capture."""
        kept = slice(None, None, every)
        return replace(
            self,
            difference=self.difference[kept],
            theta=self.theta[kept],
            time_s=self.time_s[kept],
            run=self.run[kept],
            speed=self.speed[kept],
            warmth_k=self.warmth_k[kept],
            phases=(self.phases[0][kept], self.phases[1][kept]),
        )

    def on_disc(self, orders: Float | Whole) -> tuple[Float, Float]:
        """Return cosines and sines of orders fixed to the disc, ``(n, orders, 2)``.

        Head 2 reads the disc at an angle that is larger by α.
        """
        ahead = waves(self.theta + self.alpha, orders)
        return ahead - waves(self.theta, orders), waves(self.target, orders)


def waves(angle: Float, orders: Float | Whole) -> Float:
    """Return cosine and sine of each of the evenly spaced orders, ``(n, orders, 2)``."""
    found = np.empty((angle.size, orders.size, 2))
    running = np.exp(1j * orders[0] * angle)
    step = np.exp(1j * (orders[1] - orders[0]) * angle) if orders.size > 1 else running
    for at in range(orders.size):
        found[:, at, 0], found[:, at, 1] = running.real, running.imag
        running = running * step
    return found


def problem(folder: Path) -> Problem:
    """Read the set in ``folder`` and return its least-squares problem."""
    measured = read_measurement_set(folder)
    facts = measured.table
    counts = float(facts.counts_per_rev or 1)
    repeats = facts.index_repeatability_counts
    # If no repeatability is stated, the index is rectangularly distributed within ± 1 count.
    repeats = 1.0 / math.sqrt(3.0) if repeats is None else repeats
    return Problem(
        **_of_capture(measured.capture, facts),
        **_of_reference(measured.reference),
        teeth=facts.drive_gear_teeth,
        alpha=math.radians(facts.head_separation_deg or 0.0),
        index_arcsec=math.sqrt(2.0) * max(repeats, 0.01) * ARCSEC_PER_TURN / counts,
    )


def _of_capture(capture: Capture | None, facts: Table) -> dict[str, Any]:
    none = np.zeros(0)
    if capture is None:
        names = ("difference", "theta", "time_s", "speed", "warmth_k")
        return {
            **dict.fromkeys(names, none),
            "run": np.zeros(0, dtype=np.int64),
            "phases": (none, none),
        }
    counts = float(facts.counts_per_rev or 1)
    alpha = math.radians(facts.head_separation_deg or 0.0)
    theta = capture.head1_counts * (2 * np.pi / counts)
    apart = (capture.head2_counts - capture.head1_counts) * (2 * np.pi / counts)
    speed = np.zeros(theta.size)
    for number in np.unique(capture.run):
        inside = np.flatnonzero(capture.run == number)
        seconds = capture.time_s[inside[-1]] - capture.time_s[inside[0]]
        speed[inside] = (theta[inside[-1]] - theta[inside[0]]) / max(seconds, 1e-9)
    warmth = none
    if capture.temperature_c is not None:
        warmth = capture.temperature_c - np.median(capture.temperature_c)
    per_line = counts / (facts.grating_lines or 1)
    return {
        "difference": (apart - alpha) * ARCSEC_PER_RAD,
        "theta": theta,
        "time_s": capture.time_s,
        "run": capture.run,
        "speed": speed,
        "warmth_k": warmth,
        "phases": tuple(
            np.mod(head, per_line) * (2 * np.pi / per_line)
            for head in (capture.head1_counts, capture.head2_counts)
        ),
    }


def _of_reference(reference: Reference | None) -> dict[str, Any]:
    if reference is None:
        names = ("error", "target", "reference_s", "reference_speed", "direction")
        return {
            **dict.fromkeys(names, np.zeros(0)),
            "face": np.zeros(0, dtype=np.int64),
            "faces": 1,
        }
    rows = reference.target_deg.size
    target = np.radians(reference.target_deg)
    time_s = np.zeros(rows) if reference.time_s is None else reference.time_s
    direction = np.zeros(rows) if reference.direction is None else reference.direction.astype(float)
    steps, waits = np.diff(target, append=np.nan), np.diff(time_s, append=np.inf)
    moving = (waits > 0) & (waits < STANDS_S)
    pace = np.where(moving, steps / np.where(moving, waits, 1.0), np.nan)
    speed = np.zeros(rows)
    if moving.any():
        # The last station of a pass gets the speed of the previous station.
        known = np.flatnonzero(moving)
        near = known[np.maximum(np.searchsorted(known, np.arange(rows), side="right") - 1, 0)]
        passed = np.arange(rows) - near <= 1
        speed = np.where(passed & (np.arange(rows) >= known[0]), pace[near], 0.0)
    faces = reference.faces or 1
    return {
        "error": reference.error_arcsec,
        "target": target,
        "reference_s": time_s,
        "reference_speed": speed,
        "direction": direction,
        "face": np.round(reference.target_deg * faces / 360.0).astype(np.int64) % faces,
        "faces": faces,
    }


class Fit:
    """Orthonormal basis of the present model, and the residuals of the data from this model.

    The rows are the capture's, then the reference's, then one row per run. This last row states
    that the offset of the run's index is 0, with the index's repeatability as standard deviation.
    """

    def __init__(self, given: Problem) -> None:
        """Make the base model of a set: orders 1 to 20 on the disc, offsets of runs, a zero of the
        reference."""
        runs = given.runs.size
        self.given = given
        self.rows = (given.difference.size, given.error.size, runs)
        self.data = np.concatenate([given.difference, given.error, np.zeros(runs)])
        self.scale = np.ones(self.data.size)
        capture, reference = given.on_disc(np.arange(1, BASE_ORDERS + 1))
        disc = np.vstack([_flat(capture), _flat(reference), np.zeros((runs, 2 * BASE_ORDERS))])
        offsets = np.vstack(
            [
                (given.run[:, None] == given.runs).astype(float),
                np.zeros((given.error.size, runs)),
                np.eye(runs),
            ]
        )
        zero = np.zeros((self.data.size, 1))
        zero[self.part(1)] = 1.0
        base = np.hstack([disc, offsets, zero])
        self.scale[self.part(2)] = given.index_arcsec
        self.basis = np.zeros((self.data.size, 0))
        self._take(base / self.scale[:, None])
        # Each channel is scaled by the standard deviation of its residuals from the base model.
        left = self.left()
        for channel in (0, 1):
            if self.rows[channel]:
                self.scale[self.part(channel)] = max(float(left[self.part(channel)].std()), 1e-6)
        self.basis = self.basis[:, :0]
        self._take(base / self.scale[:, None])

    def part(self, number: int) -> slice:
        """Return the slice of the rows that belong to the capture (``number`` 0), the reference
        (1), or the index (2)."""
        begin = sum(self.rows[:number])
        return slice(begin, begin + self.rows[number])

    def whole(self, block: tuple[Float | None, Float | None]) -> Float:
        """Scale the columns of both channels to units of the noise, ``(rows, places, rank)``."""
        capture, reference = block
        shape = next(part.shape[1:] for part in block if part is not None)
        found = np.zeros((self.data.size, *shape))
        for number, columns in enumerate((capture, reference)):
            if columns is not None:
                found[self.part(number)] = columns
        return found / self.scale[:, None, None]

    def add(self, columns: Float) -> None:
        """Add scaled columns ``(rows, rank)`` to the model."""
        self._take(columns)

    def _take(self, columns: Float) -> None:
        outside = columns - self.basis @ (self.basis.T @ columns)
        directions, sizes, _ = np.linalg.svd(outside, full_matrices=False)
        kept = sizes > 1e-8 * max(float(sizes.max(initial=0.0)), 1e-30)
        self.basis = np.hstack([self.basis, directions[:, kept]])

    @property
    def scaled_left(self) -> Float:
        """Return the residuals in units of the noise, ``(rows,)``."""
        scaled = self.data / self.scale
        return np.asarray(scaled - self.basis @ (self.basis.T @ scaled))

    def left(self) -> Float:
        """Return the residuals in arcseconds, ``(rows,)``."""
        return self.scaled_left * self.scale


def _flat(columns: Float) -> Float:
    return columns.reshape(columns.shape[0], math.prod(columns.shape[1:]))


Places = NDArray[np.float64] | NDArray[np.int64]
Columns = Callable[[Places], tuple[Float | None, Float | None]]


@dataclass(frozen=True)
class TextbookEffect:
    """Effect of the catalogue: its columns ``(n, places, rank)`` in both channels, at the places of
    its search."""

    name: str
    columns: Columns
    places: Places
    """Places (orders, frequencies, angles or instants) of the search; a single 0 for an effect
    without a search."""
    share: float = 1.0
    """Number of candidate places that each given place stands for; above 1 if a spectrum selected
    the place."""


def effects_of(fit: Fit) -> Iterator[TextbookEffect]:
    """Yield each effect that has columns in this module and for which the set contains the
    necessary rows and statements."""
    given = fit.given
    if given.theta.size:
        yield from _of_heads(fit)
    if given.target.size:
        yield from _of_instrument(fit)
    yield TextbookEffect("radial_error_motion", lambda at: _stator(given, at), np.arange(2, 9))


def _once(
    name: str, capture: Float | None = None, reference: Float | None = None
) -> TextbookEffect:
    """Make an effect without a search, from its columns ``(n,)`` or ``(n, rank)``."""
    parts = [
        None if part is None else part.reshape(part.shape[0], 1, -1)
        for part in (capture, reference)
    ]
    return TextbookEffect(name, lambda _: (parts[0], parts[1]), np.zeros(1))


def _of_heads(fit: Fit) -> Iterator[TextbookEffect]:
    given = fit.given
    theta, alpha = given.theta, given.alpha
    yield TextbookEffect("high_order_graduation", given.on_disc, np.arange(21, 240))
    yield _once("head_angle_error", np.ones_like(theta))
    yield _once("timing_skew", given.speed)
    electrical = [_flat(waves(phase, np.array([1, 2]))) for phase in given.phases]
    yield _once("subdivision_error", np.hstack(electrical))
    hz, searched = _strongest_line_hz(given, fit.left()[fit.part(0)])
    line = _flat(waves(given.time_s, np.array([2 * np.pi * hz])))
    each_run = given.run[:, None] == given.runs
    columns = (line[:, :, None] * each_run[:, None, :]).reshape(theta.size, -1)
    yield TextbookEffect("vibration", lambda _: (columns[:, None, :], None), np.zeros(1), searched)
    yield TextbookEffect(
        "bearing_ball_pass", lambda at: _stator(given, at), np.arange(0.35, 14.0, 0.05)
    )
    instants = np.concatenate(
        [np.linspace(*_ends(given.time_s[given.run == n]), 102)[1:-1] for n in given.runs]
    )
    yield TextbookEffect("count_slip", lambda at: (_steps(given, at), None), instants)
    yield TextbookEffect(
        "graduation_defect",
        lambda at: (
            (_bells(theta + alpha, at) - _bells(theta, at))[:, :, None],
            _bells(given.target, at)[:, :, None] if given.target.size else None,
        ),
        np.linspace(0, 2 * np.pi, 360, endpoint=False),
    )
    if given.warmth_k.size and np.ptp(given.warmth_k) > 0.5:
        yield _once("thermal_head_drift", given.warmth_k)
        first = _flat(given.on_disc(np.array([1]))[0])
        yield _once("thermal_eccentricity", first * given.warmth_k[:, None])


def _of_instrument(fit: Fit) -> Iterator[TextbookEffect]:
    given = fit.given
    first = _flat(waves(given.target, np.array([1])))
    yield _once("hysteresis", reference=given.direction)
    yield _once("reference_drift", reference=given.reference_s)
    if given.faces > 1:
        faces = (given.face[:, None] == np.arange(1, given.faces)).astype(float)
        yield _once("polygon_face_error", reference=faces)
    yield _once("polygon_eccentricity", reference=first)
    fitted = (fit.data - fit.left())[fit.part(1)]
    yield _once("autocollimator_gain", reference=fitted)
    if given.reference_speed.any():
        yield _once("latency", reference=given.reference_speed)
    if given.teeth is not None:
        gear = _flat(waves(given.target, np.array([given.teeth])))
        yield _once("drive_gear_error", reference=gear)


def _ends(values: Float) -> tuple[float, float]:
    return float(values.min()), float(values.max())


def _stator(given: Problem, orders: Places) -> tuple[Float, Float]:
    """Return cosine and sine columns of axis motion at each order; capture and reference have
    separate coefficients.
    """
    seen, read = waves(given.theta, orders), waves(given.target, orders)
    return (
        np.concatenate([seen, np.zeros_like(seen)], axis=2),
        np.concatenate([np.zeros_like(read), read], axis=2),
    )


def _steps(given: Problem, instants: Places) -> Float:
    """Return the columns of steps: 0 before each instant and 1 from the instant to the end of its
    run, ``(n, instants, 1)``."""
    number = np.searchsorted(given.time_s, instants).clip(0, given.time_s.size - 1)
    same_run = given.run[:, None] == given.run[number]
    after = given.time_s[:, None] >= instants
    return np.asarray(same_run & after, dtype=np.float64)[:, :, None]


def _bells(angle: Float, places: Places) -> Float:
    """Return a Gaussian bell with a standard deviation of 0.5° about each place, ``(n,
    places)``."""
    width = np.radians(0.5)
    found = np.zeros((angle.size, places.size))
    for at, place in enumerate(places):
        away = np.mod(angle - place + np.pi, 2 * np.pi) - np.pi
        near = np.flatnonzero(np.abs(away) < BELL_WIDTHS * width)
        found[near, at] = np.exp(-0.5 * (away[near] / width) ** 2)
    return found


def _strongest_line_hz(given: Problem, left: Float) -> tuple[float, float]:
    """Return the frequency of the strongest line above 2 Hz in all runs, and the number of
    candidates."""
    best, where, searched = 0.0, 3.0, 1.0
    for number in given.runs:
        inside = given.run == number
        rows = left[inside]
        if rows.size < 2:
            continue
        step_s = float(np.median(np.diff(given.time_s[inside])))
        power = np.abs(np.fft.rfft(rows - rows.mean(), 8 * rows.size)) ** 2 / rows.size
        hz = np.fft.rfftfreq(8 * rows.size, step_s)
        power[hz < 2.0] = 0.0
        searched += rows.size / 2
        if power.max() > best:
            best, where = float(power.max()), float(hz[power.argmax()])
    return where, searched
