"""What the forward search finds in logs of noise alone: python -m scripts.calibrate_line_search.

N logs (--logs) of each kind of noise in sim/tests/workbench/noisy_logs.py, which has none of the
search's own kernels. Prints how many show a line, a step, or residuals that are not white. With
--oscillator it prints what each place that passes all other tests gains beside an oscillator at its
frequency, in noise and in logs with one line: the threshold OSCILLATOR_GAIN of
arctrue.workbench.inference.forward.search lies above what noise reaches.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from sim.tests.workbench.noisy_logs import NULLS, clock, with_lines

from arctrue.workbench.inference.forward.record import Record, record_of
from arctrue.workbench.inference.forward.search import search_lines, search_record
from arctrue.workbench.inference.forward.tests_of_a_line import FAMILY_WISE

ROWS, STEP_S = 1200, 3.0
CLOCKS = ("even", "jitter", "pause")
SEED = 26
LINE_S, LINE_SHARE = 97.0, 0.7
"""Period of the true line, and its amplitude in deviations of the noise."""


def log_of(kind: str, number: int, *, line: bool) -> Record:
    """A log of noise, with or without a line."""
    random = np.random.default_rng((SEED, list(NULLS).index(kind), number))
    time_s = clock(random, ROWS, STEP_S, CLOCKS[number % len(CLOCKS)])
    error = NULLS[kind](random, time_s)
    if line:
        error = error + with_lines(time_s, [(LINE_SHARE * float(np.std(error)), LINE_S)])
    return record_of(
        time_s, time_s, np.zeros(ROWS, dtype=np.int64), error, np.zeros((ROWS, 0)), in_time=True
    )


def gains_of(kind: str, logs: int) -> tuple[list[float], list[float]]:
    """Gains beside an oscillator of what passes all other tests: of noise, and of true lines."""
    false: list[float] = []
    true: list[float] = []
    for number in range(logs):
        lines = search_lines(log_of(kind, number, line=False), oscillator_gain=0.0).lines
        false += [item.oscillator_gain for item in lines]
    for number in range(0, logs, 2):
        lines = search_lines(log_of(kind, number, line=True), oscillator_gain=0.0).lines
        at_line = [item.oscillator_gain for item in lines if abs(item.rate * LINE_S - 1.0) < 0.02]
        true.append(max(at_line, default=0.0))
    return false, true


def main(arguments: Sequence[str] | None = None) -> int:
    """Print what each kind of noise shows, with the thresholds as they are or to calibrate one."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--logs", type=int, default=6, help="logs of each kind (default: 6)")
    parser.add_argument("--kinds", default="", help="only kinds whose name has this word")
    parser.add_argument(
        "--oscillator", action="store_true", help="print gains beside an oscillator, threshold 0"
    )
    given = parser.parse_args(arguments)
    lines = steps = not_white = logs = 0
    for kind in (kind for kind in NULLS if given.kinds in kind):
        if given.oscillator:
            false, true = gains_of(kind, given.logs)
            shown = [", ".join(f"{gain:.1f}" for gain in sorted(each)) for each in (false, true)]
            print(f"{kind}: noise {shown[0] or '-'}; lines {shown[1]}", flush=True)
            continue
        found = [search_record(log_of(kind, at, line=False)) for at in range(given.logs)]
        own_lines, own_steps = (
            sum(bool(item.lines) for item in found),
            sum(bool(item.steps) for item in found),
        )
        own_white = sum(item.whiteness_p < FAMILY_WISE / 3.0 for item in found)
        print(
            f"{kind}: of {given.logs} logs {own_lines} with a line, {own_steps} with a step, "
            f"{own_white} not white",
            flush=True,
        )
        lines, steps, not_white = lines + own_lines, steps + own_steps, not_white + own_white
        logs += given.logs
    if not given.oscillator:
        print(f"{logs} logs: {lines} with a line, {steps} with a step, {not_white} not white")
    return 0


if __name__ == "__main__":
    sys.exit(main())
