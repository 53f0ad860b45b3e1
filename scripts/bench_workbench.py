"""Time and memory of the workbench: diagnose on a full set, and growth with the rows.

Run ``python -m scripts.bench_workbench``; ``--rows 1000000`` adds a compare of so many rows. Each
measurement is a process of its own, so that its peak memory is its own.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from arctrue.measurement import write_measurement_set
from arctrue.simulate.experiment import full
from arctrue.simulate.simulated_set import Wanted, simulate_set

ROWS = (10_000, 100_000, 400_000)
COMMANDS = ("compare", "diagnose")
FULL_ROWS = 72_000
DIAGNOSE_LIMIT_S = 20.0
DIAGNOSE_LIMIT_MB = 1024.0
READ_LIMIT_MB = 2048.0
SEED = 11


def make_set(folder: Path, rows: int) -> None:
    """A full experiment with about this many capture rows, hidden in it a warm disc centre."""
    experiment = full()
    share = -(-rows // len(experiment.runs))
    made = simulate_set(
        [Wanted("thermal_eccentricity", 0.3)], experiment.smaller(share, cycles=10), SEED
    )
    write_measurement_set(folder, made.measurement)


def make_long_set(folder: Path, rows: int, block: Path) -> None:
    """A capture of very many rows: the runs of a shorter set again and again, later each time."""
    folder.mkdir(parents=True)
    description = (block / "measurement.toml").read_text(encoding="utf-8")
    (folder / "measurement.toml").write_text(description, encoding="utf-8")
    (folder / "reference.csv").write_bytes((block / "reference.csv").read_bytes())
    lines = (block / "capture.csv").read_text(encoding="utf-8").splitlines()
    head, body = lines[0], [line.split(",", 2) for line in lines[1:]]
    runs = 1 + max(int(run) for run, _, _ in body)
    span_s = 1.0 + float(body[-1][1])
    with (folder / "capture.csv").open("w", encoding="utf-8") as file:
        file.write(head + "\n")
        for repeat in range(-(-rows // len(body))):
            file.writelines(
                f"{int(run) + repeat * runs},{float(at) + repeat * span_s:.6f},{rest}\n"
                for run, at, rest in body
            )


@dataclass(frozen=True)
class Measured:
    """One command: wall clock, processor time, peak memory, exit code."""

    seconds: float
    processor_seconds: float
    megabytes: float
    code: int


def measure(command: str, folder: Path) -> Measured:
    """``arctrue COMMAND folder`` in a process of its own. Raises RuntimeError when it breaks."""
    words = [sys.executable, "-m", "scripts.bench_workbench", "--one", command, str(folder)]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"{command} {folder}: {done.stderr or done.stdout}")
    return Measured(**json.loads(done.stdout.splitlines()[-1]))


def _one(command: str, folder: str) -> None:
    from arctrue.cli import main as arctrue

    start = time.perf_counter()
    code = 0
    with Path(os.devnull).open("w", encoding="utf-8") as nowhere:
        kept, sys.stdout = sys.stdout, nowhere
        try:
            arctrue([command, folder], standalone_mode=False)
        except SystemExit as ended:
            code = int(ended.code or 0)
        finally:
            sys.stdout = kept
    used = resource.getrusage(resource.RUSAGE_SELF)
    found = Measured(
        time.perf_counter() - start, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024.0, code
    )
    print(json.dumps(asdict(found)))


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the table; exit code 1 when the full set takes longer or more than it may."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--one", nargs=2, metavar=("COMMAND", "SET"), help=argparse.SUPPRESS)
    parser.add_argument(
        "--rows", type=int, action="append", default=[], help="a compare of so many rows as well"
    )
    options = parser.parse_args(arguments)
    if options.one:
        _one(*options.one)
        return 0
    print(
        f"{'command':10}{'capture rows':>14}{'seconds':>10}{'CPU s':>10}{'CPU µs a row':>14}"
        f"{'peak MB':>10}"
    )
    failed = False
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        wanted = [("diagnose", FULL_ROWS)]
        wanted += [(command, rows) for rows in ROWS for command in COMMANDS]
        for command, rows in wanted:
            place = folder / str(rows)
            if not place.exists():
                make_set(place, rows)
            found = _printed(command, rows, place)
            if rows == FULL_ROWS:
                failed = found.seconds > DIAGNOSE_LIMIT_S or found.megabytes > DIAGNOSE_LIMIT_MB
            failed = failed or found.code != 0
        for rows in options.rows:
            place = folder / f"long_{rows}"
            make_long_set(place, rows, folder / str(FULL_ROWS))
            found = _printed("compare", rows, place)
            failed = failed or found.megabytes > READ_LIMIT_MB or found.code != 0
    print(
        f"limits: diagnose of {FULL_ROWS:,} rows {DIAGNOSE_LIMIT_S:.0f} s and "
        f"{DIAGNOSE_LIMIT_MB:.0f} MB; long sets {READ_LIMIT_MB:.0f} MB: "
        f"{'NOT KEPT' if failed else 'kept'}"
    )
    return int(failed)


def _printed(command: str, rows: int, place: Path) -> Measured:
    found = measure(command, place)
    share = found.processor_seconds / rows * 1e6
    print(
        f"{command:10}{rows:14,}{found.seconds:10.2f}{found.processor_seconds:10.2f}"
        f"{share:14.1f}{found.megabytes:10.0f}",
        flush=True,
    )
    return found


if __name__ == "__main__":
    sys.exit(main())
