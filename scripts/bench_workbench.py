"""Measures time and memory of the workbench, for captures up to ten million rows and references up
to a million.

Run ``python -m scripts.bench_workbench``; ``--most-rows 1000000`` leaves the longest sets out. Each
measurement runs in a separate process, so that the peak memory is the peak of this measurement.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
import pyarrow as pa  # type: ignore[import-untyped]
from numpy.typing import NDArray
from pyarrow import csv

from arctrue.measurement import write_measurement_set
from arctrue.studies.simulate.experiment import full
from arctrue.studies.simulate.simulated_set import Wanted, simulate_set
from scripts.bench_rows import Row, add_option, give_out

Float = NDArray[np.float64]

ROWS = (10_000, 72_000, 150_000)
REFERENCE_ROWS = (100_000, 1_000_000)
"""Numbers of rows of the sets that have only a moving reference."""
REFERENCE_ORDER = 37.3
REFERENCE_LINE_ARCSEC = 0.05
REFERENCE_NAMED = "periodic_error"
HIDDEN = "thermal_eccentricity"
"""Effect that is hidden in every set and that ``diagnose`` must name."""
COMMANDS = ("compare", "diagnose")
LONG_ROWS = (1_000_000, 10_000_000)
LONG_RUNS = ((30.0, 20.0, 20.0), (-30.0, 20.0, 20.0), (90.0, 20.0, 20.0), (30.0, 23.5, 24.5))
"""Speed in deg/s, temperature at the start, and temperature at the end of each run."""
LONG_ROWS_A_TURN = 6_000
LONG_WARM_ARCSEC_K = 0.3
LONG_PIECE = 500_000
COUNTS_PER_REV = 1 << 24
LONG_DESCRIPTION = """schema = 1
title = "long capture"
[table]
counts_per_rev = 16777216
grating_lines = 16384
disc_diameter_mm = 107.95
head_separation_deg = 33.0
[capture]
file = "capture.csv"
[reference]
file = "reference.csv"
faces = 24
"""
LIMITS = {
    ("capture", 72_000): (10.0, 1024.0),
    ("capture", 10_000_000): (60.0, 2048.0),
    ("reference", 1_000_000): (30.0, 1024.0),
}
"""Limits of ``compare`` and of ``diagnose``: seconds of one processor core and MB, by the set's
channel and rows."""
EXPLAIN_LIMITS = {("capture", 72_000): (30.0, 1024.0)}
"""Limits of ``explain``, which diagnoses once more for each effect; it is measured on these sets
only."""
SEED = 11


def make_set(folder: Path, rows: int) -> None:
    """Write the set of a full experiment with about ``rows`` capture rows; the hidden effect is a
    disc centre that moves with the temperature."""
    experiment = full()
    share = -(-rows // len(experiment.runs))
    made = simulate_set([Wanted(HIDDEN, 0.3)], experiment.smaller(share, cycles=10), SEED)
    write_measurement_set(folder, made.measurement)


def _error_arcsec(disc: Float, warmer_k: Float) -> Float:
    """Return the angle error ε of the table of the long sets, in arcseconds. The table has four
    orders and a disc centre that moves with the temperature."""
    return (
        90.0 * np.cos(disc + 0.4)
        + 0.8 * np.cos(2.0 * disc + 1.0)
        + 0.5 * np.cos(3.0 * disc - 2.0)
        + 0.4 * np.cos(5.0 * disc + 3.0)
        + LONG_WARM_ARCSEC_K * warmer_k * np.cos(disc + 0.7)
    )


def make_long_set(folder: Path, rows: int) -> None:
    """Write a set with a capture of very many rows, in pieces, directly from the equations of the
    table.

    Four runs have equal numbers of rows, 6,000 per turn. The table turns up, down, three times as
    fast, and warm; the hidden effect is a disc centre that moves with the temperature. Five polygon
    cycles follow.
    """
    folder.mkdir(parents=True)
    (folder / "measurement.toml").write_text(LONG_DESCRIPTION, encoding="utf-8")
    random = np.random.default_rng(SEED)
    share = -(-rows // len(LONG_RUNS))
    step = 2.0 * np.pi / LONG_ROWS_A_TURN
    counts = COUNTS_PER_REV / (2.0 * np.pi)
    noise = 0.1 / 3600.0 * np.pi / 180.0
    start_s = 0.0
    with (folder / "capture.csv").open("wb") as file:
        file.write(b"run,time_s,head1_counts,head2_counts,temperature_c\n")
        for run, (speed_deg, cold, warm) in enumerate(LONG_RUNS):
            way, origin = np.sign(speed_deg), random.uniform(0.0, 2.0 * np.pi)
            period_s = step / np.radians(abs(speed_deg))
            for first in range(0, share, LONG_PIECE):
                index = np.arange(first, min(first + LONG_PIECE, share))
                angle = origin + way * step * index
                warmth = cold + (warm - cold) * index / share
                heads = []
                for offset in (0.0, np.radians(33.0)):
                    error = _error_arcsec(angle + offset, warmth - 20.0) * np.pi / 648_000.0
                    value = angle + offset + error + random.normal(0.0, noise, index.size)
                    heads.append(np.round(value * counts).astype(np.int64))
                table = pa.table(
                    [
                        np.full(index.size, run),
                        np.round(start_s + index * period_s, 6),
                        *heads,
                        np.round(warmth, 4),
                    ],
                    names=["run", "time_s", "head1_counts", "head2_counts", "temperature_c"],
                )
                csv.write_csv(table, file, csv.WriteOptions(include_header=False))
            start_s += share * period_s + 60.0
    _write_long_reference(folder, random)


def make_reference_set(folder: Path, rows: int) -> None:
    """Write a set with a reference in motion, ten turns up and ten back; the hidden effect is a
    harmonic of order 37.3, between two whole orders."""
    folder.mkdir(parents=True)
    (folder / "measurement.toml").write_text(
        'schema = 1\ntitle = "long reference"\n[reference]\nfile = "reference.csv"\n',
        encoding="utf-8",
    )
    random = np.random.default_rng(SEED)
    half = rows // 2
    way = np.arange(half) * (3600.0 / half)
    target = np.round(np.concatenate([way, way[::-1]]), 6)
    angle = np.radians(target)
    error = _error_arcsec(angle, np.zeros(target.size))
    error += REFERENCE_LINE_ARCSEC * np.cos(REFERENCE_ORDER * angle)
    error += random.normal(0.0, 0.3, target.size)
    table = pa.table(
        [
            np.repeat([0, 1], half),
            np.round(np.arange(2 * half) * 0.001, 3),
            np.repeat([1, -1], half),
            target,
            np.round(error, 4),
        ],
        names=["run", "time_s", "direction", "target_deg", "error_arcsec"],
    )
    csv.write_csv(table, folder / "reference.csv")


def _write_long_reference(folder: Path, random: np.random.Generator) -> None:
    target = np.tile(np.concatenate([np.arange(24), np.arange(24)[::-1]]) * 15.0, 5)
    error = _error_arcsec(np.radians(target), np.zeros(target.size))
    error += random.normal(0.0, 0.15, target.size)
    lines = ["run,time_s,cycle,direction,target_deg,error_arcsec,temperature_c"]
    lines += [
        f"0,{4.0 * row:.1f},{row // 48},{1 if row % 48 < 24 else -1},{angle:.1f},{value:.4f},20.0"
        for row, (angle, value) in enumerate(zip(target, error, strict=True))
    ]
    (folder / "reference.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")


@dataclass(frozen=True)
class Measured:
    """Wall-clock time, processor time, peak memory and exit code of one command."""

    seconds: float
    processor_seconds: float
    megabytes: float
    code: int
    named: str | None = None
    """Name of the effect that ``diagnose`` states."""


def measure(command: str, folder: Path) -> Measured:
    """Run ``arctrue COMMAND folder`` in a separate process. Raises RuntimeError if it fails."""
    words = [sys.executable, "-m", "scripts.bench_workbench", "--one", command, str(folder)]
    # As in a user's installation, Python keeps the bytecode of the sources that it has compiled.
    env = {**os.environ, "PYTHONDONTWRITEBYTECODE": ""}
    done = subprocess.run(words, capture_output=True, text=True, check=False, env=env)
    if done.returncode != 0:
        raise RuntimeError(f"{command} {folder}: {done.stderr or done.stdout}")
    return Measured(**json.loads(done.stdout.splitlines()[-1]))


def _one(command: str, folder: str) -> None:
    from arctrue.cli import main as arctrue

    start = time.perf_counter()
    code, named = 0, None
    written = Path(folder) / f"{command}.json"
    with Path(os.devnull).open("w", encoding="utf-8") as nowhere:
        kept, sys.stdout = sys.stdout, nowhere
        try:
            arctrue([command, folder, "--json", str(written)], standalone_mode=False)
        except SystemExit as ended:
            code = int(ended.code or 0)
        finally:
            sys.stdout = kept
    if command == "diagnose" and code == 0:
        data = json.loads(written.read_text(encoding="utf-8"))
        named = data["named"] or data["verdict"]
    used = resource.getrusage(resource.RUSAGE_SELF)
    found = Measured(
        time.perf_counter() - start,
        used.ru_utime + used.ru_stime,
        used.ru_maxrss / 1024.0,
        code,
        named,
    )
    print(json.dumps(asdict(found)))


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure and print the rows of the bench. Exit code 1: a row exceeds its limit, or
    ``diagnose`` names a wrong effect."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--one", nargs=2, metavar=("COMMAND", "SET"), help=argparse.SUPPRESS)
    parser.add_argument(
        "--most-rows", type=int, default=max(LONG_ROWS), help="leave out sets of more rows"
    )
    parser.add_argument("--runs", type=int, default=3, help="runs of each command on each set")
    add_option(parser)
    options = parser.parse_args(arguments)
    if options.one:
        _one(*options.one)
        return 0
    cases = [(("capture", rows), make_set, HIDDEN) for rows in ROWS]
    cases += [(("capture", rows), make_long_set, HIDDEN) for rows in LONG_ROWS]
    cases += [(("reference", rows), make_reference_set, REFERENCE_NAMED) for rows in REFERENCE_ROWS]
    rows = []
    with tempfile.TemporaryDirectory() as name:
        for case, make, hidden in cases:
            if case[1] > options.most_rows:
                continue
            place = Path(name) / f"{case[0]}_{case[1]}"
            make(place, case[1])
            further = ("explain",) if case in EXPLAIN_LIMITS else ()
            for command in (*COMMANDS, *further):
                runs = [measure(command, place) for _ in range(max(options.runs, 1))]
                rows.append(row(command, case, runs, hidden))
            shutil.rmtree(place)
    return give_out(rows, options.rows)


def row(command: str, case: tuple[str, int], runs: Sequence[Measured], hidden: str) -> Row:
    """Return a row with the processor seconds of a command and its limits. The row counts as
    exceeded if a run names another effect than ``hidden``."""
    channel, rows = case
    limits = EXPLAIN_LIMITS if command == "explain" else LIMITS
    most_s, most_mb = limits.get(case, (np.inf, np.inf))
    megabytes = max(run.megabytes for run in runs)
    named = {run.named for run in runs} - {None}
    remark = f"peak {megabytes:.0f} MB"
    if np.isfinite(most_s):
        remark = f"limit {most_s:.0f} s; {remark}, limit {most_mb:.0f} MB"
    if named:
        remark += f"; names {', '.join(sorted(map(str, named)))}"
    if any(run.code for run in runs):
        remark += f"; exit codes {sorted({run.code for run in runs})}"
    return Row(
        f"{command}, {channel} of {rows:,} rows",
        "CPU s",
        tuple(run.processor_seconds for run in runs),
        remark,
        kept=all(
            run.processor_seconds <= most_s
            and run.megabytes <= most_mb
            and run.code == 0
            and run.named in (None, hidden)
            for run in runs
        ),
    )


if __name__ == "__main__":
    sys.exit(main())
