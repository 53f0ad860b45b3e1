"""Compares the recorded output edges with the true angle of the table."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.instrument.turn_score import TurnScore
from arctrue.studies.demo.scene import Scene
from arctrue.studies.demo.settings import DemoSettings
from arctrue.table import PinEvents, TableState, decode_quadrature


class RecordingError(ValueError):
    """Raised if the recorded output cannot be compared with the true angle."""


@dataclass(frozen=True, slots=True)
class OutputRecording:
    """Counts and index edges decoded from the recorded output pins; arrays ``(n,)``."""

    clock: NDArray[np.int64]
    count: NDArray[np.int64]
    """Count after each edge, from an arbitrary zero."""
    index_edge: NDArray[np.int64]
    """Positions in the arrays of the edges at which Z rises, shape ``(k,)``."""


def decode_recording(output: PinEvents) -> OutputRecording:
    """Decode A, B and Z of the recorded output.

    Raises RecordingError if A and B change together.
    """
    step, illegal = decode_quadrature(output.first_levels, output.levels)
    if illegal.size:
        raise RecordingError(
            f"the output made an illegal transition at clock {output.clock[illegal[0]]} "
            f"({illegal.size} in all)"
        )
    at_index = (output.levels >> 2 & 1).astype(np.int8)
    rises = np.diff(at_index, prepend=np.int8(output.first_levels >> 2 & 1)) == 1
    moved = step != 0
    return OutputRecording(
        output.clock[moved], np.cumsum(step)[moved], np.flatnonzero(rises[moved])
    )


def pin_to_pin_latency(scene: Scene, settings: DemoSettings, output: OutputRecording) -> int:
    """Measure the number of clocks from an edge at the pins of head 1 to the same edge at the
    output.

    The function measures the run-up before the first index, in which the output is uncorrected, so
    that every input edge causes one output edge. Raises RecordingError if the delay varies.
    """
    first = np.ceil(scene.heads[0].time_s * settings.clock_hz).astype(np.int64)
    run_up = np.flatnonzero(scene.heads[0].count < 0)
    number = min(run_up.size, output.clock.size)
    if number < 100:
        raise RecordingError(
            f"only {number} output edges before the index of head 1: is the output enabled?"
        )
    delays = output.clock[:number] - first[:number]
    if delays.min() != delays.max():
        raise RecordingError(
            f"the delay from head 1 to the output varies from {delays.min()} to {delays.max()} "
            f"clocks on the uncorrected run-up"
        )
    return int(delays[0])


def output_score(
    scene: Scene,
    settings: DemoSettings,
    output: OutputRecording,
    first_clock: int,
    latency_clocks: int,
) -> TurnScore:
    """Compute the error of the output over one turn of the true angle, from ``first_clock`` on.

    The table caused the output edge of clock d between d − latency − 1 and d − latency; the edge is
    compared with the true angle in the middle of this interval. Raises RecordingError if the
    recording does not contain a whole turn.
    """
    time_s = ((output.clock - latency_clocks - 0.5) / settings.clock_hz).astype(np.float64)
    usable = (output.clock >= first_clock) & (time_s >= 0) & (time_s <= scene.motion.duration_s)
    angle = scene.motion.state(time_s[usable]).angle_rad
    turn = 2 * np.pi
    if not angle.size or angle[-1] - angle[0] < turn * (1 - 2 / settings.counts_per_rev):
        turns = (angle[-1] - angle[0]) / turn if angle.size else 0.0
        raise RecordingError(
            f"the output shows {turns:.3f} turns from clock {first_clock} on, expected a whole one"
        )
    inside = angle < angle[0] + turn
    angle = angle[inside]
    reading = output.count[usable][inside].astype(np.float64)
    error_counts = reading - angle * settings.counts_per_rev / turn
    return TurnScore.of_edges(angle, error_counts * settings.arcsec_per_count)


def index_offset_counts(
    scene: Scene, settings: DemoSettings, output: OutputRecording, latency_clocks: int
) -> float:
    """Return the distance, in counts, of the output's last Z from the zero of the corrected angle.

    Two heads cannot measure the mean of the error, so the zero of the corrected angle differs from
    the true zero by the mean of R₁ − θ. Raises RecordingError if Z never rises.
    """
    if not output.index_edge.size:
        raise RecordingError("the output never raised Z")
    clock = output.clock[output.index_edge[-1]]
    time_s = np.array([(clock - latency_clocks - 0.5) / settings.clock_hz])
    turn = 2 * np.pi
    around = np.linspace(0, turn, 3600, endpoint=False, dtype=np.float64)
    state = TableState.at_rest(around)
    mean_rad = float(np.mean(scene.table.reading_rad(0, state) - state.angle_rad))
    reading_rad = float(scene.motion.state(time_s).angle_rad[0]) + mean_rad
    off_rad = (reading_rad + np.pi) % turn - np.pi
    return off_rad * settings.counts_per_rev / turn


def faults(after: TurnScore, index_offset: float, settings: DemoSettings) -> list[str]:
    """List the limits that the corrected output exceeds; empty if the output keeps all limits."""
    found = []
    peak_counts = after.edges_reach_arcsec / settings.arcsec_per_count
    if not peak_counts <= settings.peak_limit_counts:
        found.append(
            f"the corrected error reaches {peak_counts:.2f} counts, "
            f"the limit is {settings.peak_limit_counts:g}"
        )
    if not abs(index_offset) <= settings.peak_limit_counts:
        found.append(
            f"Z of the output comes {index_offset:+.2f} counts from the zero, "
            f"the limit is {settings.peak_limit_counts:g}"
        )
    amplitude_counts = after.amplitude_arcsec / settings.arcsec_per_count
    too_large = np.flatnonzero(~(amplitude_counts <= settings.order_limit_counts))
    found += [
        f"order {index + 1} still has {amplitude_counts[index]:.3f} counts, "
        f"the limit is {settings.order_limit_counts:g}"
        for index in too_large
    ]
    return found
