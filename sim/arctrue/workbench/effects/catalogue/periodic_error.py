"""The data show a periodic error, but not the part of the machine that causes it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.effects.base import (
    Columns,
    ConditionedLane,
    Effect,
    FitContext,
    Lane,
    Leftover,
    Nonlinear,
    Parameter,
    RealLane,
    SearchParameter,
    amplitude_and_phase,
    paired_lanes,
    paired_real_lanes,
)
from arctrue.workbench.effects.capture_block import in_place_of_head
from arctrue.workbench.effects.missing import lacking_capture
from arctrue.workbench.observations import CaptureRows, Observations, ReferenceRows
from arctrue.workbench.observations.one_speed import speed_turns_s

LEAST_ROWS = 16
"""Smallest number of rows of a reference run, without a capture, in which a line is searched: four
rows in each of the four periods that a line needs."""
WHOLE = 0.01
"""An order counts as an integer if its distance from the integer is at most this value: the phase
is then wrong by at most 4° after one turn."""
OF_THE_DRIVE = 0.02
"""An order is assigned to the drive if its distance from a multiple of the tooth count is less than
this share of the tooth count. One order in 25 is this close by chance."""

OF_THE_SCHEDULE = 0.25
"""The visits of the stations count as the cause of a frequency if the frequency is nearer than this
to a multiple of half the frequency of the visits, in units of the run's frequency resolution
(1/length). With ten visits of a station, one of 10 frequencies is this close by chance."""
REGULAR = 0.05
"""The visits of a station count as a schedule if the relative spread of the times between them is
less than this."""
SAME_PHASE = 0.9
"""Share of a wave that must be the same at all visits of a station if the visits come at irregular
times. A wave of another cause has a share of about 1/n at n visits, one half at two."""
SAME_STATION_RAD = 1e-6
"""Largest angle within one station: 0.2″, more than the rounding of a file."""
TELLS_DIRECTIONS = 6.0
"""BIC advantage that a whole order with a size and a phase for each direction needs over one
sinusoid of any order: odds of 20 to 1. The whole order has one parameter more: four coefficients in
place of two coefficients and the order."""


class PeriodicError(Effect):
    """Adds cosine and sine of νθ or of 2πft to R₂ − R₁ or to ε; a search finds the order ν, any
    real number, or the frequency f.

    With ``by_direction`` the error is in the reference run, has a whole order, and has a size and a
    phase for each direction. Stiction or a drive with play causes such an error. If it were fitted
    as one sinusoid, its order would differ a little from the whole order.
    """

    name = "periodic_error"
    physics = (
        "A part of the machine repeats its error: a gear before the worm, stator slots, the "
        "steps of a motor, a pump. The data show the period and the size of the error, not the "
        "part."
    )
    equation = (
        "c cos φ + s sin φ, φ = νθ or φ = 2πft; the fit searches for ν or f, any real number; with "
        "the setting by_direction, ν is an integer and each direction has its own c and s"
    )
    source = "periodogram of uneven samples: Scargle, Astrophys. J. 263 (1982) 835"
    capture_sees = (
        "an oscillation of any order or frequency, if the part acts on the disc or on a head"
    )
    reference_sees = "an oscillation of any order or frequency"
    separated_by = (
        "runs at two speeds show whether the error is fixed to the angle, to time or to the drive"
    )
    next_measurement = "the same run at another speed: the error keeps its order, or its frequency"
    plausible = "0.05 to 30″"
    parameter_units = {
        "order": "1",
        "frequency": "Hz",
        "period": "deg",
        "period_time": "s",
        "amplitude": "arcsec",
        "phase": "deg",
    }
    defaults: ClassVar[dict[str, object]] = {"by_direction": False}
    compensation = "lanes"
    compensation_note = (
        "lanes correct only an order of the angle that a reference run has measured; an order that "
        "is not an integer needs REAL_ORDERS"
    )
    unspecific = True
    search_kind = "line"
    search = (
        SearchParameter("order", "1", 0.0, 1e7, "periods per turn; 0: an error fixed to time"),
        SearchParameter(
            "frequency", "Hz", 0.0, 1e6, "frequency of an error fixed to time; otherwise 0"
        ),
        SearchParameter(
            "in_time", "1", 0.0, 1.0, "1: fixed to time, 0: to the angle", integer=True
        ),
        SearchParameter(
            "in_capture",
            "1",
            0.0,
            1.0,
            "1: R₂ − R₁ has the error; 0: ε has the error",
            integer=True,
        ),
    )

    def __init__(self, **settings: object) -> None:
        """Make the effect; with ``by_direction`` the order is whole, and a lane with the modulator
        direction contains half of the difference of the directions."""
        super().__init__(**settings)
        if self._by_direction:
            self.search = tuple(  # type: ignore[misc, assignment]
                replace(item, integer=True) if item.name == "order" else item
                for item in type(self).search
            )
            self.compensation_note = (  # type: ignore[misc]
                "a lane corrects the mean of both directions; their difference needs MODULATORS"
            )

    @property
    def _by_direction(self) -> bool:
        return bool(self.settings["by_direction"])

    def missing(self, observations: Observations) -> list[str]:
        rows = observations.reference
        if observations.capture is not None or (rows is not None and rows.run.size >= LEAST_ROWS):
            return []
        return [lacking_capture(instead=f"a reference run of {LEAST_ROWS} rows")]

    def column_names(self, observations: Observations) -> list[str]:
        if self._by_direction:
            return [f"{kind} {way}" for way in ("up", "down") for kind in ("cos", "sin")]
        further = range(3, observations.heads + 1)
        return [
            "cos", "sin", *(f"{kind} head {head}" for head in further for kind in ("cos", "sin"))
        ]  # fmt: skip

    def capture_columns(
        self, rows: CaptureRows, nonlinear: Nonlinear, context: FitContext
    ) -> Columns | None:
        if not nonlinear["in_capture"] or self._by_direction:
            return None
        wave = _wave(rows, nonlinear)
        return None if wave is None else in_place_of_head(wave, rows)

    def reference_columns(
        self, rows: ReferenceRows, nonlinear: Nonlinear, context: FitContext
    ) -> Columns | None:
        if nonlinear["in_capture"]:
            return None
        wave = _wave(rows, nonlinear)
        if wave is None:
            return None
        if not self._by_direction:
            # The reference contains head 1 only: the columns of further heads are 0.
            return np.hstack([wave, *[np.zeros_like(wave)] * (rows.heads - 2)])
        if rows.direction is None:
            return None
        up = (rows.direction > 0.0)[:, np.newaxis]
        return np.hstack([np.where(up, wave, 0.0), np.where(up, 0.0, wave)])

    def at_place(
        self, residuals: Leftover, nonlinear: Nonlinear
    ) -> tuple[Effect, dict[str, float]]:
        """Return the effect with the nearest whole order if each direction of the reference run
        has a wave of its own; otherwise return the effect unchanged."""
        rows = residuals.observations.reference
        order = float(round(nonlinear["order"]))
        same = self, dict(nonlinear)
        if nonlinear["in_time"] or nonlinear["in_capture"] or order < 1.0:
            return same
        if self._by_direction:
            return self, {**nonlinear, "order": order}
        if rows is None or rows.direction is None or np.unique(np.sign(rows.direction)).size < 2:
            return same
        form, place = PeriodicError(by_direction=True), {**nonlinear, "order": order}
        one, apart = residuals.score(self, nonlinear), residuals.score(form, place)
        worth = float(np.log(rows.run.size)) + TELLS_DIRECTIONS
        return (form, place) if apart.gain - one.gain > worth else same

    def describe_data(self, nonlinear: Nonlinear, observations: Observations) -> str:
        rows = observations.capture if nonlinear["in_capture"] else observations.reference
        where = "R₂ − R₁" if nonlinear["in_capture"] else "the reference run"
        if nonlinear["in_time"]:
            line = f"A line in {where} of {nonlinear['frequency']:.5g} Hz "
            line += f"({1.0 / nonlinear['frequency']:.5g} s), fixed to time: "
            if rows is not None and _stands(rows):
                return (
                    f"{line}its phase continues from pass to pass of the stations, but an error of "
                    "the angle would repeat in every pass."
                )
            return (
                f"{line}the speed varies in this set, and the frequency of the line does not "
                "change with it."
            )
        order = nonlinear["order"]
        if self._by_direction:
            return ""
        line = f"A line in {where} of {order:.7g} periods a turn ({360.0 / order:.5g}°)"
        speed = None if rows is None else speed_turns_s(rows, order)
        teeth = observations.drive_gear_teeth
        multiple = 0 if teeth is None else round(order / teeth)
        if teeth is not None and multiple and abs(order / teeth - multiple) < OF_THE_DRIVE:
            line += f", {multiple} times the teeth of the drive: fixed to the drive"
        elif speed is not None:
            period_s = 1.0 / abs(order * speed)
            line += f" or {period_s:.5g} s: fixed to the angle, to time or to the drive: one speed "
            line += "cannot show which"
        elif rows is None or rows.time_s is None:
            line += ", fixed to the angle or to time: without the column time_s, the set cannot "
            line += "show which"
        else:
            line += ", fixed to the angle or to the drive: its order does not change with the speed"
        return f"{line}."

    def contradiction(
        self,
        coefficients: NDArray[np.float64],
        covariance: NDArray[np.float64],
        nonlinear: Nonlinear,
        observations: Observations,
    ) -> str | None:
        """Refuse a line in time whose phase is the same, or changes by half a period, at every
        visit to a station.

        At the stations, such a line is a function of the station and the direction of approach, or
        this function with another sign in every other pass.
        """
        rows = observations.reference
        if not nonlinear["in_time"] or nonlinear["in_capture"] or rows is None:
            return None
        visits_s = _visits_s(rows)
        if rows.time_s is None:
            return None
        if visits_s is None:
            if _repeats_at_the_stations(rows, rows.time_s, nonlinear["frequency"]) < SAME_PHASE:
                return None
            return (
                "its phase is the same at every visit of a station from the same side: an error "
                "that depends on the place and on the direction of approach looks the same"
            )
        times = nonlinear["frequency"] * visits_s
        span = float(np.ptp(rows.time_s)) / visits_s
        away = abs(times - round(times)) * span
        if abs(times - np.floor(times) - 0.5) * span <= OF_THE_SCHEDULE:
            return (
                f"its sign changes from one visit of a station to the next, {visits_s:.4g} s "
                "later: an error that alternates from pass to pass, with a load or a side, looks "
                "the same"
            )
        if round(times) < 1 or away > OF_THE_SCHEDULE:
            return None
        return (
            f"its period is that of the visits to the stations, {visits_s:.4g} s"
            + ("" if round(times) == 1 else f" divided by {round(times)}")
            + ": an error that depends on the place and on the direction of approach looks the same"
        )

    def parameters(
        self,
        coefficients: NDArray[np.float64],
        covariance: NDArray[np.float64],
        nonlinear: Nonlinear,
        observations: Observations,
    ) -> dict[str, Parameter]:
        name, unit = ("frequency", "Hz") if nonlinear["in_time"] else ("order", "1")
        if self._by_direction:
            found = {name: Parameter(nonlinear[name], 0.0, unit)}
            for number, way in enumerate(("up", "down")):
                pair = slice(2 * number, 2 * number + 2)
                cosine, sine = coefficients[pair]
                found |= amplitude_and_phase(cosine, sine, covariance[pair, pair], f"{way}_")
            return found
        found = {name: Parameter(nonlinear[name], float("nan"), unit)}
        heads = 1 + coefficients.size // 2 if nonlinear["in_capture"] else 2
        for head in range(2, heads + 1):
            pair = slice(2 * head - 4, 2 * head - 2)
            prefix = "" if head == 2 else f"head{head}_"
            cosine, sine = coefficients[pair]
            found |= amplitude_and_phase(cosine, sine, covariance[pair, pair], prefix)
        return found

    def describe_values(self, parameters: Mapping[str, Parameter]) -> str:
        if not self._by_direction:
            return ""
        ways = ", ".join(
            f"{way} {parameters[f'{way}_amplitude'].value:.3g}″ ∠ "
            f"{parameters[f'{way}_phase'].value:.0f}°"
            for way in ("up", "down")
        )
        return (
            f"A line in the reference run of order {parameters['order'].value:.0f}, {ways}: it "
            "depends on the direction."
        )

    def derived(
        self, parameters: Mapping[str, Parameter], nonlinear: Nonlinear, observations: Observations
    ) -> dict[str, Parameter]:
        if nonlinear["in_time"]:
            return {"period_time": _inverse(parameters["frequency"], 1.0, "s")}
        found = {"period": _inverse(parameters["order"], 360.0, "deg")}
        rows = observations.capture if nonlinear["in_capture"] else observations.reference
        speed = None if rows is None else speed_turns_s(rows, nonlinear["order"])
        if speed is not None:
            period_s = _inverse(parameters["order"], 1.0 / abs(speed), "s")
            found["period_time"] = period_s
            found["frequency"] = _inverse(period_s, 1.0, "Hz")
        return found

    def lanes(
        self,
        coefficients: NDArray[np.float64],
        nonlinear: Nonlinear,
        observations: Observations,
        temperature_c: float | None,
    ) -> list[Lane]:
        order = nonlinear["order"]
        if not self._of_the_angle(nonlinear) or abs(order - round(order)) > WHOLE:
            return []
        if self._by_direction:
            coefficients = 0.5 * (coefficients[:2] + coefficients[2:])
        return paired_lanes([round(order)], coefficients)

    def conditioned_lanes(
        self,
        coefficients: NDArray[np.float64],
        nonlinear: Nonlinear,
        observations: Observations,
    ) -> list[ConditionedLane]:
        if not self._by_direction or not self._of_the_angle(nonlinear):
            return []
        half = 0.5 * (coefficients[:2] - coefficients[2:])
        (lane,) = paired_lanes([round(nonlinear["order"])], half)
        return [ConditionedLane("direction", lane)]

    def real_lanes(
        self,
        coefficients: NDArray[np.float64],
        nonlinear: Nonlinear,
        observations: Observations,
    ) -> list[RealLane]:
        order = nonlinear["order"]
        is_whole = self._by_direction or abs(order - round(order)) <= WHOLE
        if is_whole or not self._of_the_angle(nonlinear):
            return []
        return paired_real_lanes([order], coefficients[:2])

    def _of_the_angle(self, nonlinear: Nonlinear) -> bool:
        """Tell whether the reference run has the effect, and the effect is fixed to the angle."""
        return not (nonlinear["in_time"] or nonlinear["in_capture"])


def _stands(rows: CaptureRows | ReferenceRows) -> bool:
    """Tell whether the rows of a reference are stations at which the table stands."""
    if not isinstance(rows, ReferenceRows):
        return False
    speed = rows.speed_rad_s
    return speed is None or bool(2 * np.count_nonzero(speed) < rows.run.size)


def _wave(rows: CaptureRows | ReferenceRows, nonlinear: Nonlinear) -> Columns | None:
    if not nonlinear["in_time"]:
        phase = nonlinear["order"] * rows.angle_rad
    elif rows.time_s is None:
        return None
    else:
        phase = 2.0 * np.pi * nonlinear["frequency"] * (rows.time_s - rows.set_start_s)
    return np.stack([np.cos(phase), np.sin(phase)], axis=1)


def _repeats_at_the_stations(
    rows: ReferenceRows, time_s: NDArray[np.float64], frequency_hz: float
) -> float:
    """Return the share of a wave in time that is the same at all visits of a station from the same
    side, 0 to 1; 0 if most stations are visited once."""
    station = np.round(np.mod(rows.target_rad, 2.0 * np.pi) / SAME_STATION_RAD)
    side = np.zeros(station.size) if rows.direction is None else rows.direction
    _, group = np.unique(np.stack([station, side]), axis=1, return_inverse=True)
    visits = np.bincount(group)
    if np.median(visits) < 2:
        return 0.0
    phase = 2.0 * np.pi * frequency_hz * time_s
    square = np.bincount(group, np.cos(phase)) ** 2 + np.bincount(group, np.sin(phase)) ** 2
    return float(np.sum(square / visits) / station.size)


def _visits_s(rows: ReferenceRows) -> float | None:
    """Return the time between visits of a station from the same side; None if this time is
    irregular."""
    if rows.time_s is None:
        return None
    station = np.round(np.mod(rows.target_rad, 2.0 * np.pi) / SAME_STATION_RAD)
    side = np.zeros(station.size) if rows.direction is None else rows.direction
    order = np.lexsort((rows.time_s, side, station))
    again = (np.diff(station[order]) == 0.0) & (np.diff(side[order]) == 0.0)
    if 2 * np.count_nonzero(again) < station.size:
        return None
    between_s = np.diff(rows.time_s[order])[again]
    usual_s = float(np.median(between_s))
    low, high = np.quantile(between_s, [0.1, 0.9])
    return usual_s if usual_s > 0.0 and float(high - low) < REGULAR * usual_s else None


def _inverse(parameter: Parameter, factor: float, unit: str) -> Parameter:
    """Return factor/value, with the same relative standard uncertainty."""
    value = factor / parameter.value
    return replace(
        parameter, value=value, sigma=value * parameter.sigma / parameter.value, unit=unit
    )
