"""Simulates a reference instrument on the table, and reads the gateware's output at its stations.

The rows of a reference run are read while the compensation is off, so that the output equals the
reading of head 1; a polygon also reads the corrected output.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.base.units import ARCSEC_PER_RAD
from arctrue.instrument import EdgeTrack, InstrumentError, Recording
from arctrue.measurement import Reference
from arctrue.studies.hidden_effect.drive import TURN_RAD
from arctrue.table import Motion

Float = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Readings:
    """Readings of the output at stations, arrays ``(n,)``."""

    motion_s: Float
    target_deg: Float
    direction: NDArray[np.int64]
    cycle: NDArray[np.int64]
    output_counts: NDArray[np.int64]
    """Counts of the output since its index."""
    true_angle_rad: Float


def zero_level(recording: Recording) -> int:
    """Return the position of the output's signal at the lower end of count 0, in which Z is high.

    The position at the rise of Z comes from the recorder, which counts every edge. An interpolation
    between kept edges could be wrong by a count if the output moves by nearly one count per clock,
    because edges come in whole clocks. Raises InstrumentError if the recording contains no Z.
    """
    if not recording.index_position.size:
        raise InstrumentError("the output never raised Z in the recorded turn")
    return int(recording.index_position[-1]) % recording.output.counts_per_rev


def counts_standing(track: EdgeTrack, clock: Float) -> NDArray[np.int64]:
    """Return the counts, from the zero of the track, at clocks at which the output stands still.

    The track records the level between two counts that the output passed: after a pass upwards the
    output shows the count above this level, after a pass downwards the count below it. Raises
    InstrumentError if edges are missing.
    """
    place = np.searchsorted(track.clock, clock) - 1
    if track.dropped or track.edges != track.clock.size or place.min() < 0:
        raise InstrumentError("the recording does not hold every edge before each station")
    step = np.sign(np.diff(track.position, prepend=track.position[0] - 1))
    # If the output passes the same level twice in sequence, the motion was reversed between the two
    # passes.
    last = np.maximum.accumulate(np.where(step != 0, np.arange(step.size), 0))
    turned = (np.arange(step.size) - last) % 2 == 1
    side = np.where(turned, -step[last], step[last])
    return np.asarray(track.position[place] - (side[place] < 0), dtype=np.int64)


def on_the_move(recording: Recording, drive: Motion, stations: int, turns: int = 1) -> Readings:
    """Read a rotary reference while the table moves: each mark of the reference that passes latches
    the output.

    Over several turns the target angle of a mark exceeds 360°.
    """
    track = recording.output
    side = 1 if track.true_angle_rad[-1] > track.true_angle_rad[0] else -1
    first = int(np.ceil(side * track.true_angle_rad[0] * stations / TURN_RAD))
    number = side * (first + np.arange(turns * stations))
    marks: Float = np.asarray(number * (TURN_RAD / stations), dtype=np.float64)
    order = slice(None, None, side)
    angle = track.true_angle_rad[order]
    position = np.interp(marks, angle, track.position[order])
    clock = np.interp(marks, angle, track.clock[order])
    share = (clock - track.clock[0]) / (track.clock[-1] - track.clock[0])
    begin, end = _motion_span_s(drive, track)
    return Readings(
        begin + share * (end - begin),
        np.asarray(number * (360.0 / stations), dtype=np.float64),
        np.full(number.size, side, dtype=np.int64),
        np.zeros(number.size, dtype=np.int64),
        np.floor(position).astype(np.int64) - zero_level(recording),
        marks,
    )


def _motion_span_s(drive: Motion, track: EdgeTrack) -> tuple[float, float]:
    """Return the instants of the motion at the first and the last edge; the table must pass the
    angle of each only once."""
    times = np.linspace(0.0, drive.duration_s, 4096)
    angle = drive.state(times).angle_rad
    order = slice(None, None, 1 if angle[-1] > angle[0] else -1)
    ends = np.interp(track.true_angle_rad[[0, -1]], angle[order], times[order])
    return float(ends[0]), float(ends[1])


def as_reference(
    readings: Readings,
    drive: Motion,
    *,
    counts_per_rev: int,
    noise_arcsec: float,
    random: np.random.Generator,
    instrument: str,
    faces: int | None,
    run: int,
) -> Reference:
    """Return the rows of a measurement set: head 1's reading minus the reference's angle, plus
    noise."""
    reading_rad = readings.output_counts * (TURN_RAD / counts_per_rev)
    error_rad = reading_rad - readings.true_angle_rad
    # Remove the whole turns by which reading and angle may differ.
    error_rad -= np.round(error_rad / TURN_RAD) * TURN_RAD
    noise = random.normal(0.0, noise_arcsec, error_rad.size)
    return Reference(
        target_deg=readings.target_deg,
        error_arcsec=error_rad * ARCSEC_PER_RAD + noise,
        run=np.full(error_rad.size, run, dtype=np.int64),
        time_s=drive.start_s + readings.motion_s,
        cycle=readings.cycle,
        direction=readings.direction,
        head1_counts=readings.output_counts,
        temperature_c=drive.temperature_c(readings.motion_s),
        instrument=instrument,
        faces=faces,
        standard_uncertainty_arcsec=noise_arcsec,
    )
