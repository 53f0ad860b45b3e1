"""Measures the processor time of parts whose speed users notice, each compared with a limit.

``python -m scripts.bench_parts`` measures the models of the gateware, the search for lines in a
long log, the import of ``arctrue``, and ``arctrue device run`` at its highest rate of lines.
"""

from __future__ import annotations

import argparse
import json
import os
import pty
import subprocess
import sys
import tempfile
import time
import tty
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from arctrue.device.recorder import last_turn
from arctrue.gateware.coefficients import Coefficients
from arctrue.gateware.compensation_pipeline import compensate
from arctrue.gateware.harmonic_unit import harmonic_unit
from arctrue.gateware.phase_unit import phase_unit
from arctrue.generated.number_formats import PHASE_WIDTH
from arctrue.workbench.inference.forward.record import record_of
from arctrue.workbench.inference.forward.search import search_lines
from scripts.bench_rows import Row, add_option, give_out

RUNS = 7
SEED = 7
ANGLES, LANES = 12_000, 32
COUNTS_PER_REV = 1 << 24
LOG_ROWS, LOG_S = 72_000, 3600.0
LINES_ARCSEC_S = ((8.5, 478.0), (4.3, 180.3), (1.8, 71.9), (0.8, 43.1))
"""Amplitude and period of the lines in the log."""
WALK_S = 30.0
"""Time constant of the slow noise of the log."""
DEVICE_LINES, LINE_BYTES = 1000, 600
PATIENCE_S = 60.0
"""Longest wait for the recorded turns in seconds."""
MODEL_LIMIT_S = {"phases and harmonics": 0.12, "the whole correction": 0.2}
SEARCH_LIMIT_S = 10.0
IMPORT_LIMIT_S = 0.1
LINE_LIMIT_MS = 6.0
"""The device sends at most 10,000 lines a minute: one line every 6 ms."""


def timed(work: Callable[[], object], runs: int) -> tuple[float, ...]:
    """Return the processor time of each run in seconds."""
    taken = []
    for _ in range(runs):
        begun = time.process_time()
        work()
        taken.append(time.process_time() - begun)
    return tuple(taken)


def model_rows() -> list[Row]:
    """Measure the models of the gateware with 12,000 angles and 32 lanes."""
    random = np.random.default_rng(SEED)
    angles = np.arange(ANGLES, dtype=np.int64) * COUNTS_PER_REV // ANGLES
    steps, offsets = random.integers(0, 2**48, LANES), random.integers(0, 1 << PHASE_WIDTH, LANES)
    amplitudes = random.integers(-(2**24), 2**24, LANES)
    orders = np.arange(LANES) * 40
    sizes, phases = random.normal(0.0, 30.0, LANES), random.uniform(-np.pi, np.pi, LANES)
    bank = Coefficients.from_harmonics(orders, sizes, phases, COUNTS_PER_REV, LANES)
    works: dict[str, Callable[[], object]] = {
        "phases and harmonics": lambda: harmonic_unit(
            phase_unit(angles, steps, offsets), amplitudes
        ),
        "the whole correction": lambda: compensate(angles, angles, bank),
    }
    return [
        _row(f"model of {name}, {ANGLES:,} angles, {LANES} lanes", timed(work, RUNS), limit_s)
        for (name, work), limit_s in zip(works.items(), MODEL_LIMIT_S.values(), strict=True)
    ]


def search_row() -> Row:
    """Measure the search for lines in an hour of 72,000 rows with slow noise."""
    random = np.random.default_rng(SEED)
    time_s = np.arange(LOG_ROWS, dtype=np.float64) * (LOG_S / LOG_ROWS)
    lines = sum(a * np.cos(2.0 * np.pi * time_s / period) for a, period in LINES_ARCSEC_S)
    kept = np.exp(-LOG_S / LOG_ROWS / WALK_S)
    slow = np.empty(LOG_ROWS)
    slow[0] = 0.0
    for row, step in enumerate(random.normal(0.0, np.sqrt(1.0 - kept**2), LOG_ROWS - 1)):
        slow[row + 1] = kept * slow[row] + step
    error = lines + slow + random.normal(size=LOG_ROWS)

    def search() -> None:
        record = record_of(
            time_s, time_s, np.zeros(LOG_ROWS, dtype=np.int64), error - error.mean(),
            np.zeros((LOG_ROWS, 0)), in_time=True, declared=1.0 / LINES_ARCSEC_S[0][1],
        )  # fmt: skip
        search_lines(record)

    return _row(f"search for lines in {LOG_ROWS:,} rows", timed(search, 3), SEARCH_LIMIT_S)


def import_row() -> Row:
    """Measure ``import arctrue`` in new processes."""
    program = (
        "import time; begun = time.process_time(); import arctrue;"
        "print(time.process_time() - begun)"
    )
    words = [sys.executable, "-c", program]
    env = {**os.environ, "PYTHONDONTWRITEBYTECODE": ""}
    taken = [
        float(subprocess.run(words, capture_output=True, check=True, env=env).stdout)
        for _ in range(RUNS)
    ]
    return _row("import arctrue", tuple(taken), IMPORT_LIMIT_S)


def device_row() -> Row:
    """Measure ``arctrue device run`` while the device sends lines of telemetry at its highest rate.

    Raises RuntimeError if the program records too few lines.
    """
    end, far = pty.openpty()
    tty.setraw(far)
    port = os.ttyname(far)
    with tempfile.TemporaryDirectory() as name:
        store = Path(name)
        words = [sys.executable, "-c", "from arctrue.cli import main; main()"]
        words += ["device", "run", port, "--store", name, "--tcp-port", "0"]
        with subprocess.Popen(words, stderr=subprocess.PIPE, text=True) as running:
            os.close(far)
            try:
                assert running.stderr is not None
                next(line for line in running.stderr if "serving" in line)
                before_s = _processor_s(running.pid)
                _send(end, 0, DEVICE_LINES)
                _wait_for(store, DEVICE_LINES)
                taken_s = _processor_s(running.pid) - before_s
            finally:
                running.terminate()
    os.close(end)
    per_line_ms = 1e3 * taken_s / DEVICE_LINES
    what = f"arctrue device run, a line of {LINE_BYTES} bytes"
    limit = f"limit {LINE_LIMIT_MS:g} ms"
    return Row(what, "CPU ms", (per_line_ms,), limit, per_line_ms <= LINE_LIMIT_MS)


def _send(end: int, first: int, last: int) -> None:
    """Write lines to the device's end of the pseudo-terminal, at the highest rate of the device."""
    for number in range(first, last):
        fields = {"turn": number, "time_s": float(number), "result": "kept", "reason": "none"}
        fields |= {"swaps": 0, "temperature_c": 40.5, "alarms": [], "pad": ""}
        fields["pad"] = "x" * (LINE_BYTES - len(json.dumps(fields)) - 2)
        time.sleep(LINE_LIMIT_MS / 1e3)
        os.write(end, json.dumps(fields).encode() + b"\r\n")


def _wait_for(store: Path, turns: int) -> None:
    until = time.monotonic() + PATIENCE_S
    record = store / "telemetry.sqlite"
    while (recorded := last_turn(record)) < turns:
        if time.monotonic() > until:
            raise RuntimeError(f"{record}: {recorded} of {turns} turns were recorded")
        time.sleep(0.05)


def _processor_s(process: int) -> float:
    """Return the processor time that a process has used; see ``proc_pid_stat(5)``."""
    fields = Path(f"/proc/{process}/stat").read_text(encoding="ascii").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def _row(what: str, taken_s: tuple[float, ...], limit_s: float) -> Row:
    """Return a row that is kept if the fastest run is within the limit."""
    return Row(what, "CPU s", taken_s, f"limit {limit_s:g} s", min(taken_s) <= limit_s)


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure and print the rows of the bench. Exit code 1: a row exceeds its limit."""
    parser = argparse.ArgumentParser(description=__doc__)
    add_option(parser)
    options = parser.parse_args(arguments)
    return give_out([*model_rows(), search_row(), import_row(), device_row()], options.rows)


if __name__ == "__main__":
    sys.exit(main())
