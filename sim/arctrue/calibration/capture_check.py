"""Checks which samples of a capture can be used, and states why other samples cannot be used."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from arctrue.base.percent import percent
from arctrue.base.runs import run_spans
from arctrue.measurement.measurement_set import Capture

Reason = Literal[
    "empty",
    "nan",
    "short_of_a_turn",
    "reversal",
    "jump",
    "wrong_step",
    "over_speed",
    "inconsistent_heads",
]

STEP_TOLERANCE = 0.10
"""Largest relative deviation of a plausible step from the run's median step (measurement set,
schema 1)."""
JUMP_STEPS = 2.0
"""Smallest ratio of a jump to the median step: no table moves by two steps in one sample period."""
LOWEST_SPEED_TOLERANCE = 0.05
"""Largest relative excess over the lowest speed at which a run belongs to the runs at the lowest
speed."""
CLOCK_HZ_DEFAULT = 100e6


class CaptureRefusedError(Exception):
    """Reports a capture that cannot be used; the last good coefficients stay in use.

    ``run``: number of the run in the file; ``sample``: index of the sample within the run, from 0.
    Each is None if the fault does not concern a single run or sample.
    """

    def __init__(
        self, reason: Reason, message: str, run: int | None = None, sample: int | None = None
    ) -> None:
        """Compose the message for the user from place and reason."""
        place = "capture" if run is None else f"run {run}"
        if sample is not None:
            place += f", sample {sample}"
        super().__init__(f"{place}: {message}")
        self.reason: Reason = reason
        self.run = run
        self.sample = sample
        self.message = message


@dataclass(frozen=True)
class WholeTurns:
    """The samples of one run that cover whole turns evenly.

    Parameters
    ----------
    run : int
        Number of the run.
    turns : int
        Number of whole turns that the samples cover.
    head1_counts : ndarray of int, shape (samples,)
        Reading of head 1, counts.
    head2_counts : ndarray of int, shape (samples,)
        Reading of head 2, counts.
    """

    run: int
    turns: int
    head1_counts: NDArray[np.int64]
    head2_counts: NDArray[np.int64]
    step_counts: float
    """Median step of head 1, with sign."""
    masked: int = 0
    """Number of masked samples between the first and the last sample."""
    further_counts: tuple[NDArray[np.int64], ...] = ()
    """Counts of heads 3 and 4, if present, each of shape (samples,)."""

    @property
    def heads(self) -> tuple[NDArray[np.int64], ...]:
        """Counts of every head, head 1 first, each (n,)."""
        return (self.head1_counts, self.head2_counts, *self.further_counts)

    @property
    def samples(self) -> int:
        """Number of samples."""
        return int(self.head1_counts.size)


def whole_turns(
    capture: Capture, counts_per_rev: int, runs: Sequence[int] | None = None, most_order: int = 1
) -> list[WholeTurns]:
    """Verify the runs and return their whole turns.

    Parameters
    ----------
    capture : Capture
        The capture of a measurement set.
    counts_per_rev : int
        Counts of one turn.
    runs : sequence of int, optional
        Numbers of the runs; default: the runs at the lowest speed.
    most_order : int, optional
        Highest order that the samples must resolve.

    Returns
    -------
    list of WholeTurns
        One entry for each run.

    Raises
    ------
    CaptureRefusedError
        A sample cannot be used; the error states the first fault.
    ValueError
        The capture lacks a run of ``runs``.
    """
    if capture.run.size == 0:
        raise CaptureRefusedError("empty", "it has no samples")
    slices = {int(capture.run[start]): slice(start, end) for start, end in run_spans(capture.run)}
    if runs is None:
        chosen = _lowest_speed(capture, slices)
    else:
        chosen = sorted(set(runs))
        missing = [run for run in chosen if run not in slices]
        if missing:
            raise ValueError(
                f"run {missing[0]} is not in the capture, which has runs "
                + ", ".join(str(run) for run in slices)
            )
    return [_verified(capture, run, slices[run], counts_per_rev, most_order) for run in chosen]


def _lowest_speed(capture: Capture, slices: dict[int, slice]) -> list[int]:
    speeds = {}
    for run, rows in slices.items():
        kept = _not_masked(capture, rows)
        steps = np.abs(np.diff(capture.head1_counts[rows][kept]))
        times = np.diff(capture.time_s[rows][kept])
        # Without a step there is no speed; the check of the run reports this fault.
        speeds[run] = (
            float(np.median(steps)) / max(float(np.median(times)), 1e-12) if steps.size else 0.0
        )
    moving = [speed for speed in speeds.values() if speed > 0.0]
    if not moving:
        return list(slices)
    limit = min(moving) * (1.0 + LOWEST_SPEED_TOLERANCE)
    return [run for run, speed in speeds.items() if 0.0 < speed <= limit]


def _not_masked(capture: Capture, rows: slice) -> NDArray[np.int64]:
    """Return the indices within the run of the samples that are not masked."""
    if capture.mask is None:
        return np.arange(capture.run[rows].size)
    return np.flatnonzero(~capture.mask[rows])


def _verified(
    capture: Capture, run: int, rows: slice, counts_per_rev: int, most_order: int
) -> WholeTurns:
    kept = _not_masked(capture, rows)
    heads = tuple(head[rows][kept] for head in capture.heads)
    time_s = capture.time_s[rows][kept]
    named = [(f"head {number}", head) for number, head in enumerate(heads, start=1)]
    for head, column in (("time", time_s), *named):
        bad = np.flatnonzero(~np.isfinite(column))
        if bad.size:
            raise CaptureRefusedError("nan", f"{head} is not a number", run, int(kept[bad[0]]))
    samples = heads[0].size
    if samples < 2:
        are = "sample that is" if samples == 1 else "samples that are"
        raise CaptureRefusedError(
            "short_of_a_turn",
            f"it has {samples} {are} not masked; capture at least one whole turn",
            run,
        )
    medians = [float(np.median(np.diff(head) / np.diff(kept))) for head in heads]
    _check_steps(run, heads, kept, medians, counts_per_rev)
    _check_sampling(run, medians[0], counts_per_rev, most_order)
    _check_speed(run, heads[0], time_s, kept, capture.clock_hz or CLOCK_HZ_DEFAULT)

    step = medians[0]
    travel = np.abs(heads[0] - heads[0][0])
    # A turn of K samples ends one step after its last sample; the tolerance is half a step.
    turns = int((travel[-1] + 1.5 * abs(step)) // counts_per_rev)
    if turns < 1:
        raise CaptureRefusedError(
            "short_of_a_turn",
            f"it covers {travel[-1] / counts_per_rev:.4f} of a turn in {samples} samples; "
            "capture at least one whole turn, or leave this run out (--run)",
            run,
            samples - 1,
        )
    inside = travel < turns * counts_per_rev - 0.5 * abs(step)
    used = int(np.count_nonzero(inside))
    masked = int(kept[used - 1] - kept[0]) + 1 - used
    further = tuple(head[:used] for head in heads[2:])
    return WholeTurns(run, turns, heads[0][:used], heads[1][:used], step, masked, further)


def _check_steps(
    run: int,
    heads: tuple[NDArray[np.int64], ...],
    kept: NDArray[np.int64],
    medians: list[float],
    counts_per_rev: int,
) -> None:
    """Refuse a run with a step that is not plausible.

    ``kept``: indices within the run of the samples that are not masked. Across k − 1 masked
    samples, k steps are expected.
    """
    gaps = np.diff(kept)
    faults = []
    for number, (head, median) in enumerate(zip(heads, medians, strict=True), start=1):
        steps = np.diff(head)
        # Rounding alone can change a step by one count, a large share of a step of few counts.
        allowed = max(STEP_TOLERANCE * abs(median), 1.0)
        bad = np.flatnonzero(np.abs(steps - median * gaps) > allowed * gaps)
        if median == 0.0:
            raise CaptureRefusedError("short_of_a_turn", f"head {number} stands still", run, 0)
        if bad.size:
            index = int(bad[0])
            over_one = int(steps[index] - median * (gaps[index] - 1))
            faults.append((int(kept[index + 1]), number, over_one, median))
    if len(set(np.sign(medians).tolist())) > 1 and not faults:
        raise CaptureRefusedError(
            "inconsistent_heads", "the heads count in opposite directions; swap A and B of one", run
        )
    if not faults:
        return
    sample, number, found, median = min(faults)
    expected = f"head {number} steps by {found} counts, the run's median is {median:.0f}"
    if abs(found) > JUMP_STEPS * abs(median):
        turns = round((found - median) / counts_per_rev)
        lost = (
            f"; {abs(turns)} whole turn{'s are' if abs(turns) > 1 else ' is'} missing"
            if turns and abs(found - median - turns * counts_per_rev) < abs(median)
            else "; were samples or edges lost?"
        )
        raise CaptureRefusedError("jump", "a jump: " + expected + lost, run, sample)
    if found * median < 0:
        raise CaptureRefusedError("reversal", "a reversal: " + expected, run, sample)
    raise CaptureRefusedError(
        "wrong_step",
        f"a wrong step: {expected}, and {percent(STEP_TOLERANCE)} is allowed; "
        "was the speed even and the sampling regular?",
        run,
        sample,
    )


def _check_sampling(run: int, step: float, counts_per_rev: int, most_order: int) -> None:
    """Refuse a run with too few samples per turn for the highest order."""
    least_samples = 2 * most_order + 2
    if abs(step) * least_samples > counts_per_rev:
        raise CaptureRefusedError(
            "over_speed",
            f"over-speed: a turn has {counts_per_rev / abs(step):.1f} samples, "
            f"order {most_order} needs {least_samples}; turn slower or sample faster",
            run,
            1,
        )


def _check_speed(
    run: int,
    head1_counts: NDArray[np.int64],
    time_s: NDArray[np.float64],
    kept: NDArray[np.int64],
    clock_hz: float,
) -> None:
    """Refuse a run with more counts between two neighbouring samples than the decoder can count.

    ``kept``: index within the run of each sample; masked samples are left out before.
    """
    times = np.diff(time_s)
    steps = np.abs(np.diff(head1_counts))
    # The decoder counts one edge per clock at most. The file states times to a microsecond, so that
    # a single interval can be wrong by a microsecond.
    fast = np.flatnonzero(steps > clock_hz * (times + 1e-6))
    if fast.size:
        index = int(fast[0])
        raise CaptureRefusedError(
            "over_speed",
            f"over-speed: {steps[index]} counts in {times[index]:.6f} s; "
            f"at {clock_hz / 1e6:g} MHz the decoder counts at most one edge per clock",
            run,
            int(kept[index + 1]),
        )
