"""How much the ARM has to do for one calibration: instructions counted in QEMU, and the time.

QEMU's ``-icount shift=0`` lets an instruction take a nanosecond of its clock, which its global
timer counts in ticks of 10 ns; the firmware reports its longest step in ticks of its own timer.
``python -m scripts.bench_firmware`` after ``make firmware``.
"""

from __future__ import annotations

import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from arctrue.calibration import fourier, least_squares, whole_turns
from arctrue.measurement import Capture

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from sim.tests.calibration.synthetic import Disc, turn_angles  # noqa: E402
from sim.tests.firmware.emulator import build, core_window, running  # noqa: E402

TIMER_HZ = 325_000_000
"""What the firmware supposes of its timer (650 MHz / 2)."""
NS_A_TICK = 10
PROCESSOR_HZ = 667e6
CYCLES_AN_INSTRUCTION = (1.0, 2.0)
"""Dual issue at best, double-precision chains at worst: a range, not a measurement."""
GOAL_MS = {"fourier": 50.0, "least_squares": 250.0}
CASES = ((12_000, 40), (12_000, 20), (12_000, 10), (6_000, 40), (3_000, 40))
METHODS = ("fourier", "least_squares")


def turn(samples: int) -> NDArray[np.int64]:
    """Counts (2, n) of one turn and the sample that closes it."""
    disc = Disc({1: (150.0, 0.4), 2: (6.0, 4.2), 3: (1.2, 2.9), 11: (0.4, 1.0)})
    theta = turn_angles(samples, 2)[: samples + 1]
    return disc.heads(theta, 0.1, np.random.default_rng(1))


def instructions(samples: int, orders: int, method: str) -> float:
    """Of the step that works on the bank, from reading it to the swap."""
    window = core_window(turn(samples))
    # No index at first: nothing is worked on while the parameters are set.
    held = bytearray(window)
    head1 = 0x0C0
    held[head1] = 0
    with tempfile.TemporaryDirectory() as name:
        options = ("-icount", "shift=0,sleep=off")
        with running(Path(name), bytes(held), *options) as machine:
            machine.wait_for("help tells the commands\r\n")
            machine.send(f"set orders {orders}")
            machine.send(f"set method {METHODS.index(method)}")
            machine.write_memory(0x4000_0000 + head1, b"\x01\x00\x00\x00")
            status = machine.ask("status", "phase swap", 60.0)
    (line,) = [text for text in status.splitlines() if text.startswith("longest_step_us")]
    ticks = float(line.split()[1]) * TIMER_HZ / 1e6
    return ticks * NS_A_TICK


def reference_ms(samples: int, orders: int, method: str) -> float:
    """numpy's time on this machine for the same turn."""
    counts = turn(samples)
    capture = Capture(
        run=np.zeros(samples + 1, dtype=np.int64),
        time_s=np.arange(samples + 1, dtype=np.float64) * 1e-3,
        head1_counts=counts[0],
        head2_counts=counts[1],
    )
    call = {"fourier": fourier, "least_squares": least_squares}[method]
    started = time.perf_counter()
    turns = whole_turns(capture, 1 << 24, None, orders)
    call(turns, 1 << 24, float(np.radians(33.0)), np.arange(1, orders + 1))
    return (time.perf_counter() - started) * 1e3


def main() -> int:
    """Print the table and up to how many cycles an instruction the goals hold; 1: not even at 1."""
    build()
    missed = 0
    low, high = CYCLES_AN_INSTRUCTION
    print(f"{'method':<14} samples orders  M instr.  ms at 667 MHz, CPI {low:g}-{high:g}  numpy/ms")
    for method in METHODS:
        for samples, orders in CASES:
            number = instructions(samples, orders, method)
            times = [number * cycles / PROCESSOR_HZ * 1e3 for cycles in (low, high)]
            goal = GOAL_MS[method]
            holds = (samples, orders) == CASES[0]
            note = f"  goal {goal:g} ms holds to CPI {goal / times[0]:.2f}" if holds else ""
            print(
                f"{method:<14} {samples:7d} {orders:6d} {number / 1e6:9.2f} "
                f"{times[0]:11.1f} to {times[1]:6.1f}          "
                f"{reference_ms(samples, orders, method):8.1f}{note}"
            )
            missed += holds and times[0] > goal
    return 1 if missed else 0


if __name__ == "__main__":
    raise SystemExit(main())
