"""Counts wrong answers by how unlike the benchmark a set is.

The sets are drawn here, in plain numpy from geometry, and share nothing with the generator of the
benchmark: polygons alone, dense logs of one pass with slow noise, and captures of one or two runs,
with causes of the catalogue and with strangers. ``python -m
scripts.calibrate_probabilities`` prints the counts that stand in
``workbench/diagnose/probabilities.py``.

``--across FOLDER`` takes the sets of a benchmark's run with both generators in place of these: the
shares are learned on one generator's answers and scored on the other's.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from numpy.typing import NDArray

from arctrue.measurement import Capture, MeasurementSet, Reference, Table
from arctrue.studies.benchmark.across import across
from arctrue.studies.benchmark.answers import judged_sets
from arctrue.studies.benchmark.diagnosis import diagnosed
from arctrue.studies.benchmark.score import by_generator
from arctrue.workbench.diagnose.diagnosis import Diagnosis

Float = NDArray[np.float64]
Random = np.random.Generator

COUNTS = 1 << 24
ALPHA = np.radians(33.0)
ARCSEC = np.pi / 648_000.0
TABLE = Table(
    counts_per_rev=COUNTS,
    grating_lines=16_384,
    disc_diameter_mm=107.95,
    head_separation_deg=33.0,
)


@dataclass(frozen=True)
class Drawn:
    """A set, and the names that are right for it: none where nothing is hidden, or a stranger."""

    measurement: MeasurementSet
    cause: str
    right: frozenset[str]
    hidden: bool


def _disc(angle: Float) -> Float:
    return 90.0 * np.cos(angle + 0.4) + 0.8 * np.cos(2 * angle + 1.0) + 0.5 * np.cos(3 * angle)


def _slow(random: Random, rows: int, size: float, constant_rows: float) -> Float:
    """Ornstein–Uhlenbeck noise of this standard deviation, (rows,)."""
    keep = np.exp(-1.0 / constant_rows)
    drive = random.normal(0.0, size * np.sqrt(1.0 - keep**2), rows)
    found = np.empty(rows)
    found[0] = random.normal(0.0, size)
    for row in range(1, rows):
        found[row] = keep * found[row - 1] + drive[row]
    return found


def _resonance(random: Random, time: Float, hertz: float, size: float) -> Float:
    """An oscillation that noise drives, coherent over some 5 periods, (rows,)."""
    turn = 2.0 * np.pi * hertz * (time[1] - time[0])
    loss = np.exp(-turn / 30.0)
    found = np.zeros(time.size)
    drive = random.normal(size=time.size)
    for row in range(2, time.size):
        found[row] = (
            2 * loss * np.cos(turn) * found[row - 1] - loss**2 * found[row - 2] + drive[row]
        )
    return np.asarray(size * found / found.std())


def _telegraph(random: Random, rows: int, size: float, flips: int) -> Float:
    at = np.sort(random.integers(0, rows, flips))
    return size * (np.searchsorted(at, np.arange(rows)) % 2).astype(np.float64)


POLYGON = ("none", "hysteresis", "varying_hysteresis", "reference_drift", "walk", "direction_order")
LOG = ("none", "line", "two_lines", "step", "resonance", "chirp")
CAPTURE = (
    "none", "high_order_graduation", "count_slip", "vibration", "telegraph", "resonance", "bump",
    "even_warming",
)  # fmt: skip


def polygon(cause: str, random: Random) -> Drawn:
    """A reference alone: few stations up and down, one to six cycles."""
    stations, cycles = int(random.choice([8, 12, 24, 36])), int(random.integers(1, 7))
    up = np.arange(stations) * 360.0 / stations
    target = np.tile(np.concatenate([up, up[::-1]]), cycles)
    side = np.tile(np.repeat([1.0, -1.0], stations), cycles)
    angle, rows = np.radians(target), target.size
    time: Float = np.asarray(np.arange(rows) * 5.0, dtype=np.float64)
    noise = float(random.uniform(0.05, 0.3))
    size = noise * float(np.exp(random.uniform(np.log(3.0), np.log(60.0))))
    place = np.round(target * stations / 360.0).astype(int) % stations
    factor = 1.0 + 0.2 * random.normal(size=stations)
    shapes: dict[str, Callable[[], Float]] = {
        "none": lambda: np.zeros(rows),
        "hysteresis": lambda: 0.5 * size * side,
        "varying_hysteresis": lambda: 0.5 * size * side * factor[place],
        "reference_drift": lambda: size * time / time[-1],
        "walk": lambda: size * np.cumsum(random.normal(size=rows)) / np.sqrt(rows),
        "direction_order": lambda: size * (side > 0) * np.cos(5.0 * angle),
    }
    shape = shapes[cause]()
    error = np.asarray(_disc(angle) + shape + random.normal(0.0, noise, rows), dtype=np.float64)
    reference = Reference(
        target, error, run=np.zeros(rows, dtype=np.int64), time_s=time,
        cycle=np.repeat(np.arange(cycles), 2 * stations), direction=side.astype(np.int64),
    )  # fmt: skip
    right = {"hysteresis", "varying_hysteresis", "reference_drift"}
    names = {cause.removeprefix("varying_")} if cause in right else set()
    made = MeasurementSet(Table(), None, reference, title="polygon")
    return Drawn(made, cause, frozenset(names), cause != "none")


def log(cause: str, random: Random) -> Drawn:
    """A dense log of one pass, with slow noise."""
    rows = int(random.integers(1_500, 4_000))
    time: Float = np.asarray(np.arange(rows) * 0.1, dtype=np.float64)
    target: Float = np.asarray(time * float(random.uniform(0.5, 3.0)))
    noise = float(random.uniform(0.1, 0.5))
    slow = _slow(random, rows, noise * float(random.uniform(0.3, 2.0)), random.uniform(20, 300))
    size = noise * float(np.exp(random.uniform(np.log(2.0), np.log(20.0))))
    hertz = float(random.uniform(0.05, 1.5))
    wave = 2.0 * np.pi * time
    shapes: dict[str, Callable[[], Float]] = {
        "none": lambda: np.zeros(rows),
        "line": lambda: size * np.cos(wave * hertz + 0.3),
        "two_lines": lambda: size * (np.cos(wave * hertz) + 0.4 * np.cos(wave * 2.3 * hertz)),
        "step": lambda: size * (time > time[-1] * random.uniform(0.3, 0.7)),
        "resonance": lambda: _resonance(random, time, hertz, size),
        "chirp": lambda: size * np.cos(wave * hertz * (1.0 + time / time[-1])),
    }
    shape = shapes[cause]()
    error = np.asarray(shape + slow + random.normal(0.0, noise, rows))
    reference = Reference(target, error, run=np.zeros(rows, dtype=np.int64), time_s=time)
    names = {"periodic_error", "drive_gear_error", "vibration"} if "line" in cause else set()
    made = MeasurementSet(Table(), None, reference, title="log")
    return Drawn(made, cause, frozenset(names), cause != "none")


def _of_head2(cause: str, random: Random, time: Float, size: float) -> Float:
    """What a cause adds to head 2 in one run, arcseconds, (rows,)."""
    share = (time - time[0]) / (time[-1] - time[0])
    first = time[0] < 1.0
    at, hertz = float(random.uniform(0.2, 0.8)), 0.5 + 7.5 * size % 1.0
    shapes: dict[str, Callable[[], Float]] = {
        "vibration": lambda: size * np.cos(2.0 * np.pi * time * hertz),
        "count_slip": lambda: 20 * 0.0772 * (share > at) * float(first),
        "telegraph": lambda: _telegraph(random, time.size, size, 12),
        "resonance": lambda: _resonance(random, time, hertz, size),
        "bump": lambda: 3 * size * np.exp(-0.5 * ((share - at) / 0.05) ** 2),
        "even_warming": lambda: size * time / 36.0,
    }
    return np.asarray(shapes[cause]() if cause in shapes else 0.0 * share, dtype=np.float64)


def capture(cause: str, random: Random) -> Drawn:
    """A capture of both heads in one or two runs, without a reference."""
    columns: list[list[Float]] = [[], [], [], [], []]
    runs, noise = int(random.integers(1, 3)), 0.1
    size = noise * float(np.exp(random.uniform(np.log(3.0), np.log(15.0))))
    order = int(random.integers(25, 70))
    for run in range(runs):
        rows, turns = 3_600, 3
        way = 1.0 if run == 0 else -1.0
        angle = random.uniform(0, 2 * np.pi) + way * np.arange(rows) * 2 * np.pi * turns / rows
        time: Float = np.asarray(run * 60.0 + np.arange(rows) * 0.01, dtype=np.float64)
        share = (time - time[0]) / (time[-1] - time[0])
        warm = 20.0 + (time / 36.0 if cause == "even_warming" else 0.5 * np.sin(np.pi * share))
        head2 = _of_head2(cause, random, time, size)
        readings = []
        for offset, further in ((0.0, np.zeros(rows)), (ALPHA, head2)):
            seen = angle + offset
            error = _disc(seen) + further
            if cause == "high_order_graduation":
                error = error + size * np.cos(order * seen + 0.2)
            value = seen + (error + random.normal(0.0, noise, rows)) * ARCSEC
            readings.append(np.round(value / (2.0 * np.pi) * COUNTS))
        for column, values in zip(
            columns, (np.full(rows, float(run)), time, *readings, warm), strict=True
        ):
            column.append(np.asarray(values, dtype=np.float64))
    joined = [np.concatenate(column) for column in columns]
    made = MeasurementSet(
        TABLE,
        Capture(
            joined[0].astype(np.int64), joined[1], joined[2].astype(np.int64),
            joined[3].astype(np.int64), temperature_c=joined[4],
        ),
        None,
        title="capture",
    )  # fmt: skip
    names = {cause} & {"high_order_graduation", "count_slip", "vibration"}
    if cause == "vibration":
        names = {"vibration", "periodic_error"}
    return Drawn(made, cause, frozenset(names), cause != "none")


WORLDS: tuple[tuple[Callable[[str, Random], Drawn], tuple[str, ...]], ...] = (
    (polygon, POLYGON),
    (log, LOG),
    (capture, CAPTURE),
)


def drawn(number: int, seed: int) -> Iterator[Drawn]:
    """``number`` sets of every cause of every world."""
    for place, (world, causes) in enumerate(WORLDS):
        for kind, cause in enumerate(causes):
            for one in range(number):
                yield world(cause, np.random.default_rng([seed, place, kind, one]))


def judged(found: Diagnosis, truth: Drawn) -> tuple[str, bool] | None:
    """The kind of answer, and whether it is right; None for answers that say nothing."""
    if found.verdict in ("cannot_tell", "bad_data"):
        return None
    if found.verdict in ("named", "ambiguous"):
        right = bool(truth.right & set(found.effect_class))
        # A class that a stranger stands beside says that it may be a stranger.
        if found.verdict == "ambiguous" and found.described is not None and truth.hidden:
            right = right or not truth.right
        return "names", right
    if found.verdict == "unknown":
        return "unknown", truth.hidden and not truth.right
    return "adequate", not truth.hidden


def main(arguments: Sequence[str] | None = None) -> int:
    """Print every answer, and the counts by the ways in which the sets are unlike."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sets", type=int, default=6, help="sets of every cause (default: 6)")
    parser.add_argument("--seed", type=int, default=26, help="of the drawn sets (default: 26)")
    parser.add_argument(
        "--across", type=Path, help="folder of a benchmark's run with both generators"
    )
    given = parser.parse_args(arguments)
    if given.across is not None:
        for line in across(by_generator(judged_sets([given.across], "arctrue", None))):
            print(line.words())
        return 0
    answers: Counter[tuple[str, int]] = Counter()
    wrong: Counter[tuple[str, int]] = Counter()
    score, stated = 0.0, 0
    for truth in drawn(given.sets, given.seed):
        _, found = diagnosed(truth.measurement)
        said = judged(found, truth)
        if said is None:
            continue
        kind, right = said
        place = (kind, len(found.unlike))
        answers[place] += 1
        wrong[place] += not right
        first = max(found.probability.values())
        score += float(np.log(first if right else max(1.0 - first, 1e-6)))
        stated += 1
        names = ", ".join(found.effect_class) or "–"
        print(
            f"{truth.measurement.title} {truth.cause}: {found.verdict} {names}, "
            f"{'right' if right else 'WRONG'}, {first:.3f}, {len(found.unlike)} ways",
            flush=True,
        )
    for place in sorted(answers):
        print(f"{place[0]} at {place[1]} ways: {wrong[place]} of {answers[place]} wrong")
    share = sum(wrong.values()) / max(stated, 1)
    constant = share * np.log(max(share, 1e-9)) + (1 - share) * np.log(max(1 - share, 1e-9))
    print(f"log score {score / max(stated, 1):.3f} an answer; a constant {constant:.3f}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
