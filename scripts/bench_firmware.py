"""Counts the ARM instructions of one calibration in QEMU, and estimates its time.

A separate image (``firmware/bench``) runs both methods of calibration on a turn in the emulated
capture window. It also runs a plain implementation of each method, compiled with the same options:
one sine and one cosine of the C library per sample and order. With QEMU's ``-icount shift=0`` an
instruction takes a nanosecond of the emulated clock. The global timer counts this clock in ticks of
10 ns, so that the count is repeatable and exact to 10 instructions. The processor time of numpy is
measured on this machine.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from arctrue.calibration import fourier, least_squares, whole_turns
from arctrue.gateware.register_access import register_named
from arctrue.measurement import Capture

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from sim.tests.calibration.synthetic import Disc, turn_angles  # noqa: E402
from sim.tests.firmware.emulator import build, core_window, running, word  # noqa: E402

from scripts.bench_rows import Row, add_option, give_out  # noqa: E402

IMAGE = ROOT / "build" / "firmware" / "pynq_z2" / "bench.elf"
NS_A_TICK = 10
PROCESSOR_HZ = 667e6
"""Clock frequency of the fastest XC7Z020-1. The boards of this project run at 650 MHz."""
CYCLES_AN_INSTRUCTION = (1.0, 2.0)
"""Assumed range of cycles per instruction. In the best case two instructions are issued at once. In
the worst case each operation on doubles waits for the previous one; the FPU of the Cortex-A9 issues
a multiplication every second clock and an addition every clock."""
GOAL_MS = {"fourier": 50.0, "least_squares": 250.0}
JUDGED_ORDERS = 32
"""Number of loaded orders that the measured judgement compares with a turn, as in firmware/bench;
the calibration does not fit these orders."""
JUDGE_SHARE = 0.7
"""Largest permitted number of instructions for judging JUDGED_ORDERS loaded orders in one turn, as
a share of the instructions of a calibration with the same samples, 40 orders and least squares."""
CASES = ((12_000, 40), (12_000, 20), (12_000, 10), (6_000, 40), (3_000, 40))
METHODS = {"fourier": fourier, "least_squares": least_squares}
SAME_RESULT = 1e-6
"""Tolerance for the difference of two results, as a share of the largest harmonic. The firmware's
iteration stops at 10⁻⁴″ of about 150″."""
NUMPY_RUNS = 7
EMULATION_S = 400.0


def turn(samples: int) -> NDArray[np.int64]:
    """Return the counts (2, n) of the samples of one turn and of the next sample."""
    disc = Disc({1: (150.0, 0.4), 2: (6.0, 4.2), 3: (1.2, 2.9), 11: (0.4, 1.0)})
    theta = turn_angles(samples, 2)[: samples + 1]
    return disc.heads(theta, 0.1, np.random.default_rng(1))


def instructions(samples: int, orders: int) -> dict[str, float]:
    """Return the number of instructions of every part of the bench image. Raises AssertionError if
    the result of a plain implementation differs."""
    window = bytearray(core_window(turn(samples)))
    scratch = register_named("scratch").address
    window[scratch : scratch + 4] = word(orders)
    with tempfile.TemporaryDirectory() as name:
        options = ("-icount", "shift=0,sleep=off")
        with running(Path(name), bytes(window), *options, image=IMAGE) as machine:
            lines = machine.wait_for("end\r\n", EMULATION_S).splitlines()[:-1]
    counted = {}
    for line in lines:
        part, ticks, off = line.split()
        # The last number that a method prints is the reason for a refusal, or 0.
        assert float(off) * 1e-9 <= SAME_RESULT, f"{part}: {line}"
        counted[part] = float(ticks) * NS_A_TICK
    return counted


def numpy_ms(samples: int, orders: int, method: str) -> tuple[float, ...]:
    """Return the processor time, in ms, of several runs of the Python calibration of the same turn
    on this machine."""
    counts = turn(samples)
    capture = Capture(
        run=np.zeros(samples + 1, dtype=np.int64),
        time_s=np.arange(samples + 1, dtype=np.float64) * 1e-3,
        head1_counts=counts[0],
        head2_counts=counts[1],
    )
    times = []
    for _ in range(NUMPY_RUNS):
        started = time.process_time()
        turns = whole_turns(capture, 1 << 24, None, orders)
        METHODS[method](turns, 1 << 24, float(np.radians(33.0)), np.arange(1, orders + 1))
        times.append((time.process_time() - started) * 1e3)
    return tuple(times)


def rows_of(method: str, samples: int, orders: int, counted: dict[str, float]) -> list[Row]:
    """Return rows that compare the number of ARM instructions with the number in the plain
    implementation, and the time with the goal and with numpy."""
    around = counted["verify"] + (counted["reading_function"] if method == "fourier" else 0.0)
    number = around + counted[method]
    plain = around + counted[f"plain_{method}"]
    low, high = (number * cycles / PROCESSOR_HZ * 1e3 for cycles in CYCLES_AN_INSTRUCTION)
    what = f"`{method}`, {samples:,} samples, {orders} orders"
    comparison = f"{low:.0f} to {high:.0f} ms at {PROCESSOR_HZ / 1e6:g} MHz"
    kept = True
    if (samples, orders) == CASES[0]:
        goal = GOAL_MS[method]
        comparison += f", goal {goal:g} ms (met up to {goal / low:.1f} cycles per instruction)"
        kept = low <= goal
    return [
        Row(
            f"{what}: million instructions",
            "10⁶",
            (number / 1e6,),
            f"a sine and a cosine per sample and order, same ARM: {plain / 1e6:.1f} "
            f"({plain / number:.1f} times); {comparison}",
            kept=kept,
        ),
        Row(f"{what}: numpy on this machine", "ms", numpy_ms(samples, orders, method), comparison),
    ]


def judge_rows(samples: int, counted: dict[str, float]) -> list[Row]:
    """Return a row with the number of instructions that judging JUDGED_ORDERS loaded orders takes,
    and with its share of a calibration from the same turn."""
    number, plain = counted["judge"], counted["plain_judge"]
    low, high = (number * cycles / PROCESSOR_HZ * 1e3 for cycles in CYCLES_AN_INSTRUCTION)
    share = number / counted["least_squares"]
    return [
        Row(
            f"judgement of {JUDGED_ORDERS} loaded orders that are not fitted, {samples:,} samples: "
            "million instructions",
            "10⁶",
            (number / 1e6,),
            f"a sine and a cosine per sample and order, same ARM: {plain / 1e6:.1f} "
            f"({plain / number:.1f} times); {low:.0f} to {high:.0f} ms at "
            f"{PROCESSOR_HZ / 1e6:g} MHz; {share:.2f} of a calibration, goal {JUDGE_SHARE:g}",
            kept=share <= JUDGE_SHARE,
        )
    ]


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure and print the rows of the bench. Exit code 1: a row misses its goal even at one cycle
    per instruction."""
    parser = argparse.ArgumentParser(description=__doc__)
    add_option(parser)
    given = parser.parse_args(arguments)
    build()
    subprocess.run(["make", "-s", "-C", str(ROOT / "firmware"), "bench"], check=True)
    counted = {case: instructions(*case) for case in CASES}
    rows = [
        row for method in METHODS for case in CASES for row in rows_of(method, *case, counted[case])
    ]
    rows += judge_rows(CASES[0][0], counted[CASES[0]])
    return give_out(rows, given.rows)


if __name__ == "__main__":
    raise SystemExit(main())
