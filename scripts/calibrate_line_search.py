"""Counts the lines (periodic errors in time) and steps that the forward search falsely finds in
logs of noise alone.

``python -m scripts.calibrate_line_search`` makes N logs (--logs) of each kind of noise in
sim/tests/workbench/noisy_logs.py, whose noise processes differ from the kernels of the search. The
script prints in how many logs the search finds a line, a step, or residuals that are not white.
With --short it searches steps at few stations and in short logs, with 20 orders in the model. With
--orders it searches lines in logs with up to 20 orders in the model. With --oscillator it lists the
lines that pass all other tests, in noise and in logs with one true line. For each line it prints
the gain: the increase of the log likelihood with the line minus the increase with an oscillator (a
resonance) of the same frequency in the noise model. The threshold OSCILLATOR_GAIN of
arctrue.workbench.inference.forward.search is above the gains in logs of noise.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from itertools import product

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from sim.tests.workbench.noisy_logs import NULLS, clock, with_lines

from arctrue.workbench.inference.forward.events import search_steps
from arctrue.workbench.inference.forward.noise_of_record import noise_with
from arctrue.workbench.inference.forward.record import Record, record_of
from arctrue.workbench.inference.forward.search import search_lines, search_record
from arctrue.workbench.inference.forward.tests_of_a_line import FAMILY_WISE

ROWS, STEP_S = 1200, 3.0
CLOCKS = ("even", "jitter", "pause")
SEED = 26
LINE_S, LINE_SHARE = 97.0, 0.7
"""Period of the true line, and its amplitude divided by the noise's standard deviation."""


def log_of(kind: str, number: int, *, line: bool) -> Record:
    """Return a log of noise, with a true line or without it."""
    random = np.random.default_rng((SEED, list(NULLS).index(kind), number))
    time_s = clock(random, ROWS, STEP_S, CLOCKS[number % len(CLOCKS)])
    error = NULLS[kind](random, time_s)
    if line:
        error = error + with_lines(time_s, [(LINE_SHARE * float(np.std(error)), LINE_S)])
    return record_of(
        time_s, time_s, np.zeros(ROWS, dtype=np.int64), error, np.zeros((ROWS, 0)), in_time=True
    )


SHORT = {
    "12 stations 4 times": (12, 4, False),
    "36 stations 4 times": (36, 4, False),
    "60 stations up and down": (60, 2, True),
    "60 rows": (60, 1, False),
    "120 rows": (120, 1, False),
}
"""Number of stations, number of cycles, and whether every other cycle goes back; the keys are the
names of the designs. The rows of a design with one cycle cover 17°, the stations of the others a
whole turn."""


def short_of(kind: str, design: str, number: int) -> Record:
    """Return a record of noise alone, at few stations (10 s each) or in a short log; the model
    contains orders 1 to 20."""
    random = np.random.default_rng((SEED, list(NULLS).index(kind), number, *design.encode()))
    stations, cycles, back = SHORT[design]
    row = np.arange(stations * cycles)
    place, cycle = row % stations, row // stations
    down = back & (cycle % 2 == 1)
    place = np.where(down, stations - 1 - place, place)
    angle = place * (2.0 * np.pi if cycles > 1 else 0.3) / stations
    waves = np.outer(angle, np.arange(1, 21))
    columns = np.hstack([np.cos(waves), np.sin(waves), np.where(down, -1.0, 1.0)[:, np.newaxis]])
    time_s = clock(random, row.size, 10.0, "even" if cycles > 1 else "jitter")
    error = NULLS[kind](random, time_s)
    return record_of(
        time_s, time_s, np.zeros(row.size, dtype=np.int64), error, columns, in_time=True
    )


def steps_of(record: Record) -> int:
    """Return the number of steps that the search finds in the noise of a record."""
    none = np.zeros((record.clock.size, 0))
    return len(search_steps(record, none, noise_with(record, none)))


ORDER_ROWS, ORDERS = (150, 300, 600), (0, 6, 20)
"""Numbers of rows of the logs, which cover 0.95 turns, and numbers of orders in the models."""


def log_with_orders(kind: str, rows: int, orders: int, number: int) -> Record:
    """Return a log of noise over an hour, whose model contains ``orders`` orders."""
    random = np.random.default_rng((SEED, list(NULLS).index(kind), number, rows))
    time_s = clock(random, rows, 3600.0 / rows, CLOCKS[number % len(CLOCKS)])
    waves = np.outer(np.arange(rows) * (0.95 * 2.0 * np.pi / rows), np.arange(1, orders + 1))
    columns = np.hstack([np.cos(waves), np.sin(waves)])
    error = NULLS[kind](random, time_s)
    return record_of(time_s, time_s, np.zeros(rows, dtype=np.int64), error, columns, in_time=True)


def orders_main(logs: int, kinds: str) -> int:
    """Print in how many logs of noise the search finds a line while orders are in the model."""
    every = total = 0
    for rows, orders in product(ORDER_ROWS, ORDERS):
        own = 0
        for kind in (kind for kind in NULLS if kinds in kind):
            found = [search_lines(log_with_orders(kind, rows, orders, at)) for at in range(logs)]
            own += sum(bool(item.lines) for item in found)
            total += logs
        every += own
        print(f"{rows} rows, {orders} orders: {own} with a line", flush=True)
    print(f"{total} logs: {every} with a line")
    return 0


def short_main(logs: int, kinds: str) -> int:
    """Print in how many short records of noise the search finds a step."""
    every = total = 0
    for design in SHORT:
        for kind in (kind for kind in NULLS if kinds in kind):
            found = sum(bool(steps_of(short_of(kind, design, at))) for at in range(logs))
            if found:
                print(f"{design}, {kind}: of {logs} sets {found} with a step", flush=True)
            every, total = every + found, total + logs
    print(f"{total} short sets: {every} with a step")
    return 0


def gains_of(kind: str, logs: int) -> tuple[list[float], list[float]]:
    """For lines that pass all other tests, return the gains in log likelihood over an oscillator:
    first for lines found in noise, then for true lines (0 for a true line that was not found)."""
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
    """Print the number of false finds in each kind of noise, or, by an option, the other tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--logs", type=int, default=6, help="logs of each kind (default: 6)")
    parser.add_argument("--kinds", default="", help="only kinds whose name has this word")
    parser.add_argument(
        "--oscillator", action="store_true", help="list lines with their gains over an oscillator"
    )
    parser.add_argument("--short", action="store_true", help="steps in stations and short logs")
    parser.add_argument(
        "--orders", action="store_true", help="lines in logs with orders in the model"
    )
    given = parser.parse_args(arguments)
    if given.orders:
        return orders_main(given.logs, given.kinds)
    if given.short:
        return short_main(given.logs, given.kinds)
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
