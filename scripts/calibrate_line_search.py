"""How large lines come out of noise alone, and how many true ones pass the oscillator's threshold.

python -m scripts.calibrate_line_search [--logs N] [--kinds WORD]: N logs of each kind of noise in
sim/tests/workbench/noisy_logs.py, half of them with one line. Prints what a line gains beside an
oscillator at its frequency where all other tests pass: the threshold OSCILLATOR_GAIN of
arctrue.workbench.inference.forward.search lies between what noise and what lines reach.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Sequence

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from sim.tests.workbench.noisy_logs import NULLS, clock, with_lines

from arctrue.workbench.inference.forward.record import record_of
from arctrue.workbench.inference.forward.search import OSCILLATOR_GAIN, LineSearch, search_lines

ROWS, STEP_S = 1200, 3.0
CLOCKS = ("even", "jitter", "pause")
SEED = 26
LINE_S, LINE_SHARE = 97.0, 0.7
"""Period of the true line, and its amplitude in deviations of the noise."""


def search_of(kind: str, number: int, *, line: bool) -> LineSearch:
    """The search of one log with the oscillator's threshold at 0."""
    random = np.random.default_rng((SEED, list(NULLS).index(kind), number))
    time_s = clock(random, ROWS, STEP_S, CLOCKS[number % len(CLOCKS)])
    error = NULLS[kind](random, time_s)
    if line:
        error = error + with_lines(time_s, [(LINE_SHARE * float(np.std(error)), LINE_S)])
    record = record_of(
        time_s, time_s, np.zeros(ROWS, dtype=np.int64), error, np.zeros((ROWS, 0)), in_time=True
    )
    return search_lines(record, oscillator_gain=0.0)


def main(arguments: Sequence[str] | None = None) -> int:
    """Print a line of each kind, then what the threshold lets through."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--logs", type=int, default=6, help="logs of each kind (default: 6)")
    parser.add_argument("--kinds", default="", help="only kinds whose name has this word")
    given = parser.parse_args(arguments)
    kinds = [kind for kind in NULLS if given.kinds in kind]
    false: list[float] = []
    true: list[float] = []
    began = time.process_time()
    for kind in kinds:
        here: list[float] = []
        for number in range(given.logs):
            here += [item.oscillator_gain for item in search_of(kind, number, line=False).lines]
        found: list[float] = []
        for number in range(0, given.logs, 2):
            lines = search_of(kind, number, line=True).lines
            at_line = [
                item.oscillator_gain for item in lines if abs(item.rate * LINE_S - 1.0) < 0.02
            ]
            found.append(max(at_line, default=0.0))
        print(
            f"{kind}: noise {', '.join(f'{gain:.1f}' for gain in sorted(here)) or '-'}; "
            f"lines {', '.join(f'{gain:.1f}' for gain in sorted(found))}",
            flush=True,
        )
        false, true = false + here, true + found
    passed = sum(gain > OSCILLATOR_GAIN for gain in false)
    kept = sum(gain > OSCILLATOR_GAIN for gain in true)
    print(
        f"{given.logs * len(kinds)} logs of noise: {len(false)} places pass all other tests, "
        f"largest {max(false, default=0.0):.1f}; {passed} above {OSCILLATOR_GAIN:g}. "
        f"{kept} of {len(true)} lines above it. "
        f"{(time.process_time() - began) / (1.5 * given.logs * len(kinds)):.2f} s a log."
    )
    return 0


if __name__ == "__main__":
    sys.exit(main())
