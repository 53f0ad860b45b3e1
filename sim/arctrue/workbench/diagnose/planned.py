"""Plans possible next measurements: calculates the rows that they would give.

The rows have conditions only (angle, time, temperature, direction, ...) and no measured values. The
columns of an effect, calculated from these conditions, show the effect in the planned measurement.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from arctrue.measurement.asked import (
    FACES,
    FASTER,
    MORE_SAMPLES,
    MORE_TURNS,
    TURNED_FACES,
    WARMER_K,
)
from arctrue.workbench.observations import CaptureRows, Observations, ReferenceRows

Float = NDArray[np.float64]
Integer = NDArray[np.int64]
Rows = TypeVar("Rows", CaptureRows, ReferenceRows)

PAUSE_S = 600.0
"""Pause between the measured and the planned rows, long enough to show drifts of an hour."""
MOST_NEW_ROWS = 100_000
"""Largest number of planned rows, to limit cost: more rows do not change which measurement
distinguishes two effects."""
CYCLES = 5
"""Number of cycles of a planned polygon measurement: half of the paper's ten."""
STATION_S = 4.0
"""Time for one planned station: settling and reading of an autocollimator."""
EVENLY = 0.98
"""Smallest correlation of temperature and time at which the temperature counts as changing evenly;
with this correlation, the columns of two effects count as equal as well (EQUAL_COLUMNS in
:mod:`confounded`)."""
MOVING_STATIONS = 360
"""Number of stations of a planned reference that is read while the table moves: one per degree."""


@dataclass(frozen=True)
class PlannedMeasurement:
    """A planned measurement: its name for programs (None without such a name), its description, and
    a function that adds its rows."""

    kind: str | None
    words: str
    with_it: Callable[[Observations], Observations | None]
    """Function that adds the rows of this measurement to a set and returns the new set; it returns
    None if the table or the set does not allow the measurement."""


def _joined(before: Rows, after: Rows) -> Rows:
    """Append the rows ``after`` to ``before``; fields that are not arrays keep the values of
    ``before``."""
    values: dict[str, Any] = {}
    for item in fields(before):
        old, new = getattr(before, item.name), getattr(after, item.name)
        both = isinstance(old, np.ndarray) and isinstance(new, np.ndarray)
        values[item.name] = np.concatenate([old, new]) if both else old
    values["conditions"] = {
        name: np.concatenate([column, after.conditions[name]])
        for name, column in before.conditions.items()
    }
    return type(before)(**values)


def _usual(rows: CaptureRows | ReferenceRows, count: int) -> dict[str, Any]:
    """Return the uncertainty and the user's additional columns for planned rows; each value is the
    median of its column in the set."""
    return {
        "u_arcsec": None
        if rows.u_arcsec is None
        else np.full(count, float(np.median(rows.u_arcsec))),
        "conditions": {
            name: np.full(count, float(np.median(column)))
            for name, column in rows.conditions.items()
        },
    }


def _further_run(
    observations: Observations,
    *,
    faster: float = 1.0,
    back: bool = False,
    warmer_k: float = 0.0,
    cooled: bool = False,
    turns: float | None = None,
    finer: float = 1.0,
) -> Observations | None:
    """Return the set with one additional run. The run equals the first run, except that it begins
    0.5 rad farther on, has one more sample, and has the requested changes."""
    rows = observations.capture
    if rows is None:
        return None
    first = np.flatnonzero(rows.run == 0)
    travel = float(rows.angle_rad[first[-1]] - rows.angle_rad[first[0]])
    duration = float(rows.time_s[first[-1]] - rows.time_s[first[0]])
    if first.size < 3 or duration <= 0.0 or travel == 0.0:
        return None
    longer = 1.0 if turns is None else turns * 2.0 * np.pi / abs(travel)
    if longer < 1.0 or (warmer_k and rows.temperature_c is None):
        return None
    rises = _rises_with_time(rows)
    if cooled and not rises:
        return None
    # The run has one more sample than the first run, so that the new samples are between the old
    # ones.
    count = int(min(first.size * longer * finer, MOST_NEW_ROWS)) + 1
    share = np.arange(count) / (count - 1)
    way = -1.0 if back else 1.0
    angle = rows.angle_rad[first[0]] + 0.5 + way * travel * longer * share
    start = float(rows.time_s.max()) + PAUSE_S
    further = rows.further_places_rad
    new = CaptureRows(
        run=np.full(count, rows.runs, dtype=np.int64),
        revolution=int(rows.revolution.max()) + 1 + _turns(angle),
        time_s=start + duration * longer / faster * share,
        temperature_c=_temperature_c(
            rows,
            start + duration * longer / faster * share,
            warmer_k,
            goes_on=rises and not cooled,
        ),
        direction=np.full(count, way * np.sign(travel)),
        speed_rad_s=np.full(count, way * travel / duration * faster),
        angle_rad=angle,
        disc1_rad=angle,
        disc2_rad=angle + rows.head_separation_rad,
        line1_rad=angle,
        line2_rad=angle + rows.head_separation_rad,
        electrical1_rad=_phase(angle, observations),
        electrical2_rad=_phase(angle + rows.head_separation_rad, observations),
        run_start_s=np.full(count, start),
        set_start_s=rows.set_start_s,
        session_start_s=rows.session_start_s,
        runs=rows.runs + 1,
        head_separation_rad=rows.head_separation_rad,
        reference_temperature_c=rows.reference_temperature_c,
        difference_arcsec=np.zeros(count),
        further_places_rad=further,
        further_line_rad=_side_by_side([angle + place for place in further]),
        further_electrical_rad=_side_by_side(
            [_phase(angle + place, observations) for place in further]
        ),
        **_usual(rows, count),
    )
    if rows.channel is not None:
        new = _in_channels(new, rows.channels)
    joined = replace(_joined(rows, new), runs=rows.runs + rows.channels)
    reference = observations.reference
    if reference is not None:
        reference = replace(reference, capture_runs=joined.runs)
    return replace(observations, capture=joined, reference=reference)


def _rises_with_time(rows: CaptureRows | ReferenceRows) -> bool:
    """Tell whether the temperature changes evenly with the time, so that the rows cannot separate
    them: their correlation is at least EVENLY, over the set and within the runs."""
    celsius = rows.temperature_c
    if celsius is None or rows.time_s is None:
        return False
    size = np.maximum(np.bincount(rows.run), 1)
    of_run = [np.bincount(rows.run, values) / size for values in (rows.time_s, celsius)]
    time_s = rows.time_s - of_run[0][rows.run]
    within = celsius - of_run[1][rows.run]
    if float(np.ptp(within)) == 0.0:
        return False
    found = (np.corrcoef(rows.time_s, celsius), np.corrcoef(time_s, within))
    return all(abs(float(item[0, 1])) >= EVENLY for item in found)


def _temperature_c(
    rows: CaptureRows, time_s: Float, warmer_k: float, *, goes_on: bool
) -> Float | None:
    """Return the temperature of the planned rows: the temperature of the first run or, with
    ``goes_on``, the continued straight line of the set's temperature."""
    if rows.temperature_c is None:
        return None
    if goes_on:
        return _continued_c(rows, time_s) + warmer_k
    first = float(np.median(rows.temperature_c[rows.run == 0]))
    return np.full(time_s.size, first + warmer_k)


def _continued_c(rows: CaptureRows | ReferenceRows, time_s: Float) -> Float:
    """Return the straight line of the set's temperature at later times."""
    assert rows.temperature_c is not None
    assert rows.time_s is not None
    start = float(rows.time_s[0])
    line = np.polyfit(rows.time_s - start, rows.temperature_c, 1)
    return np.asarray(np.polyval(line, time_s - start))


def _side_by_side(columns: list[Float | None]) -> Float | None:
    there = [column for column in columns if column is not None]
    return np.stack(there, axis=1) if there else None


def _in_channels(rows: CaptureRows, channels: int) -> CaptureRows:
    """Repeat a run of three or four heads for each channel; each channel is then a run."""
    count = rows.run.size
    again = np.tile(np.arange(count), channels)
    channel = np.repeat(np.arange(channels), count)
    repeated = rows.part(again)
    last = int(rows.revolution.min())
    return replace(
        repeated,
        run=repeated.run + channel,
        revolution=last + (repeated.revolution - last) * channels + channel,
        channel=channel,
    )


def _turns(angle_rad: Float) -> Integer:
    return np.asarray(np.abs(angle_rad - angle_rad[0]) // (2.0 * np.pi), dtype=np.int64)


def _phase(angle_rad: Float, observations: Observations) -> Float | None:
    if observations.grating_lines is None:
        return None
    return np.asarray(np.mod(angle_rad * observations.grating_lines, 2.0 * np.pi))


def _stations(observations: Observations) -> ReferenceRows:
    """Return the stations of a polygon, up and back, at times after all measured rows."""
    up = np.arange(FACES) * (2.0 * np.pi / FACES)
    target = np.tile(np.concatenate([up, up[::-1]]), CYCLES)
    count = target.size
    ends = [
        float(rows.time_s.max())
        for rows in (observations.capture, observations.reference)
        if rows is not None and rows.time_s is not None
    ]
    start = max(ends, default=0.0) + PAUSE_S
    time: Float = start + STATION_S * np.arange(count, dtype=np.float64)
    capture = observations.capture
    return ReferenceRows(
        run=np.zeros(count, dtype=np.int64),
        cycle=np.repeat(np.arange(CYCLES), 2 * FACES),
        time_s=time,
        temperature_c=np.full(count, observations.reference_temperature_c),
        direction=np.tile(np.repeat([1.0, -1.0], FACES), CYCLES),
        target_rad=target,
        angle_rad=target,
        line_rad=target,
        face=np.round(target * FACES / (2.0 * np.pi)).astype(np.int64) % FACES,
        faces=FACES,
        electrical1_rad=_phase(target, observations),
        teeth=observations.drive_gear_teeth,
        speed_rad_s=None,
        run_start_s=np.full(count, start),
        set_start_s=start,
        session_start_s=start if capture is None else capture.session_start_s,
        heads=observations.heads,
        middle_time_s=float(0.5 * (time[0] + time[-1])),
        reference_temperature_c=observations.reference_temperature_c,
        error_arcsec=np.zeros(count),
        capture_runs=observations.runs,
    )


def _reference(observations: Observations) -> Observations | None:
    if observations.reference is not None:
        return None
    capture = observations.capture
    if capture is not None:
        capture = replace(capture, reference_in_time=True)
    stations = _stations(observations)
    return replace(observations, capture=capture, reference=stations)


def _reference_back(observations: Observations) -> Observations | None:
    rows = observations.reference
    if rows is None or rows.direction is None or np.unique(rows.direction).size > 1:
        return None
    back = replace(_later(rows), direction=-rows.direction)
    return replace(observations, reference=_joined(rows, back))


def _reference_cooled(observations: Observations) -> Observations | None:
    rows = observations.reference
    if rows is None or not _rises_with_time(rows):
        return None
    return replace(observations, reference=_joined(rows, _later(rows, cooled=True)))


def _later(rows: ReferenceRows, *, cooled: bool = False) -> ReferenceRows:
    """Return the same rows again, after a pause; a temperature that rises evenly with the time goes
    on rising, unless it is ``cooled`` to that of the first rows."""
    cycle = None if rows.cycle is None else rows.cycle + int(rows.cycle.max()) + 1
    run = rows.run + int(rows.run.max()) + 1
    if rows.time_s is None or rows.run_start_s is None:
        return replace(rows, cycle=cycle, run=run)
    after = float(np.ptp(rows.time_s)) + PAUSE_S
    time_s: Float = rows.time_s + after
    goes_on = not cooled and _rises_with_time(rows)
    return replace(
        rows,
        cycle=cycle,
        run=run,
        time_s=time_s,
        temperature_c=_continued_c(rows, time_s) if goes_on else rows.temperature_c,
        run_start_s=rows.run_start_s + after,
    )


def _polygon_turned(observations: Observations) -> Observations | None:
    """Return the set with the reference repeated, the polygon turned by a third of a face."""
    rows = observations.reference
    if rows is None or rows.face is None or rows.faces is None:
        return None
    shift = 2.0 * np.pi / rows.faces * TURNED_FACES
    electrical = rows.electrical1_rad
    if electrical is not None and observations.grating_lines is not None:
        electrical = np.mod(electrical + shift * observations.grating_lines, 2.0 * np.pi)
    turned = replace(
        _later(rows),
        target_rad=rows.target_rad + shift,
        angle_rad=rows.angle_rad + shift,
        line_rad=rows.line_rad + shift,
        electrical1_rad=electrical,
    )
    return replace(observations, reference=_joined(rows, turned))


def _moving_reference(observations: Observations) -> Observations | None:
    """Return the set with three additional reference runs in motion: one in each direction, and one
    three times as fast."""
    rows, capture = observations.reference, observations.capture
    if rows is None or rows.time_s is None or (rows.speed_rad_s is not None):
        return None
    slow = 0.5 if capture is None else float(np.abs(capture.speed_rad_s).min())
    rises = _rises_with_time(rows)
    passes = []
    for number, speed in enumerate((slow, -slow, FASTER * slow)):
        up: Float = np.linspace(0.0, 2.0 * np.pi, MOVING_STATIONS, endpoint=False)
        target: Float = up if speed > 0 else up[::-1]
        start = float(rows.time_s.max()) + PAUSE_S * (number + 1)
        cycle = None if rows.cycle is None else rows.cycle.max() + 1 + number
        time_s: Float = start + np.abs(target - target[0]) / abs(speed)
        celsius: Float = np.full(target.size, rows.reference_temperature_c)
        passes.append(
            replace(
                rows,
                run=np.full(target.size, rows.run.max() + 1 + number),
                cycle=None if cycle is None else np.full(target.size, cycle),
                time_s=time_s,
                temperature_c=_continued_c(rows, time_s) if rises else celsius,
                direction=np.full(target.size, np.sign(speed)),
                target_rad=target,
                angle_rad=target,
                line_rad=target,
                face=None,
                faces=None,
                electrical1_rad=_phase(target, observations),
                speed_rad_s=np.full(target.size, speed),
                run_start_s=np.full(target.size, start),
                error_arcsec=np.zeros(target.size),
                **_usual(rows, target.size),
            )
        )
    still = replace(rows, speed_rad_s=np.zeros(rows.run.size), face=None, faces=None)
    for item in passes:
        still = _joined(still, item)
    return replace(observations, reference=still)


PLANS = (
    PlannedMeasurement(
        "speed", "one more run at three times the speed", lambda o: _further_run(o, faster=FASTER)
    ),
    PlannedMeasurement(
        "direction", "one more run in the other direction", lambda o: _further_run(o, back=True)
    ),
    PlannedMeasurement(
        "again",
        "the same run once more, after the table has stood still for ten minutes",
        _further_run,
    ),
    PlannedMeasurement(
        "again",
        "the same run once more, after the table is back at the temperature of the first run (this "
        "set's temperature changes evenly with the time)",
        lambda o: _further_run(o, cooled=True),
    ),
    PlannedMeasurement(
        "warm",
        "one more run with the table 4 K warmer",
        lambda o: _further_run(o, warmer_k=WARMER_K),
    ),
    PlannedMeasurement(
        "turns",
        f"one run of {MORE_TURNS} turns or more",
        lambda o: _further_run(o, turns=float(MORE_TURNS)),
    ),
    PlannedMeasurement(
        "samples",
        f"one run with {MORE_SAMPLES} times as many samples a turn",
        lambda o: _further_run(o, finer=float(MORE_SAMPLES)),
    ),
    PlannedMeasurement(
        "reference",
        "a reference run: a polygon of 24 faces, in both directions",
        _reference,
    ),
    PlannedMeasurement(
        None,
        "the same reference run once more, with the temperature held or back at its first value "
        "(this set's temperature changes evenly with the time)",
        _reference_cooled,
    ),
    PlannedMeasurement(
        "reference_back", "the reference run in the other direction too", _reference_back
    ),
    PlannedMeasurement(
        "polygon_turned",
        "the reference run once more, the polygon turned on the table by a third of a face "
        "(as a second run in reference.csv)",
        _polygon_turned,
    ),
    PlannedMeasurement(
        "moving_reference",
        "a reference that is read on the move, both ways and at two speeds",
        _moving_reference,
    ),
)
"""Planned measurements, in ascending order of their cost."""
