"""Handles the measurements that a diagnosis requests: writes instructions and checks the new run.

A requested run of the heads repeats the first run of the set, with at most one condition changed
(for example the speed). A requested reference run repeats the reference run of the set in a similar
way, or is the set's first reference run. The recorded run is compared with the run that it repeats,
within the limits below.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.base.runs import run_spans
from arctrue.measurement.measurement_set import Capture, MeasurementSet, Reference

FASTER = 3.0
WARMER_K = 4.0
MORE_TURNS = 30
MORE_SAMPLES = 5
FACES = 24
TURNED_FACES = 1.0 / 3.0
"""Values of a requested run, in this order: factor of the speed, rise of temperature in K, number
of turns, factor of the samples per turn, faces of the polygon if the set does not state them, and
the share of a face by which the polygon is turned."""

ENOUGH = 2.0 / 3.0
"""Fraction of the requested value (speed, rise of temperature, number) that a run must reach."""
SAME_SPEED = 0.2
"""Relative difference between two speeds below which they count as equal."""
SAME_TEMPERATURE_K = 1.0
"""Largest change of temperature that is not reported; a larger change means that two conditions
changed."""
TURNED_WITHIN = 0.1
"""Largest deviation from the requested rotation of the polygon (a third of a face in either
direction), as a share of a face."""


@dataclass(frozen=True)
class Run:
    """One run of a capture, described by the quantities that a request can state."""

    speed_deg_s: float
    """Speed in degrees a second, positive upwards."""
    turns: float
    samples_a_turn: float
    temperature_c: float | None

    @property
    def way(self) -> str:
        """Direction of the motion as the commands name it."""
        return "up" if self.speed_deg_s > 0.0 else "down"


@dataclass(frozen=True)
class Came:
    """Result of the comparison with a request: faults and remarks, as sentences."""

    faults: list[str]
    remarks: list[str]


def runs_of(capture: Capture, counts_per_rev: float) -> list[Run]:
    """Return those runs of a capture that move and have at least two samples."""
    found = []
    for start, end in run_spans(capture.run):
        travel = float(capture.head1_counts[end - 1] - capture.head1_counts[start]) / counts_per_rev
        seconds = float(capture.time_s[end - 1] - capture.time_s[start])
        if end - start < 2 or travel == 0.0 or seconds <= 0.0:
            continue
        celsius = capture.temperature_c
        found.append(
            Run(
                speed_deg_s=360.0 * travel / seconds,
                turns=abs(travel),
                samples_a_turn=(end - start - 1) / abs(travel),
                temperature_c=None if celsius is None else float(np.mean(celsius[start:end])),
            )
        )
    return found


def at_the_table(kind: str, before: MeasurementSet) -> list[str]:
    """Return instructions for the operator of the table, one sentence each. Raises ValueError for
    an unknown kind, or if the set lacks the run to repeat."""
    asked = _asked(kind)
    if isinstance(asked, _OfACapture):
        return asked.steps(_first_run(kind, before))
    return asked.steps(before)


def by_device(kind: str) -> bool:
    """Tell whether ``arctrue capture`` can record this measurement: the command records one turn of
    both heads."""
    return kind in ("speed", "direction", "again", "warm")


def came(kind: str, before: MeasurementSet, taken: MeasurementSet) -> Came:
    """Compare the set ``taken`` with the measurement that was requested in addition to the set
    ``before``.

    If ``taken`` has several runs, the run with the fewest faults is compared. Raises ValueError for
    an unknown kind, or if ``before`` lacks the run to repeat.
    """
    asked = _asked(kind)
    if isinstance(asked, _OfACapture):
        first = _first_run(kind, before)
        if taken.capture is None:
            return Came(["it has no capture of both heads"], [])
        runs = runs_of(taken.capture, float(taken.table.counts_per_rev or 1))
        if not runs:
            return Came(["the table turns in none of its runs"], [])
        return min(
            (Came(asked.faults(first, run), _remarks(kind, first, run)) for run in runs),
            key=lambda one: len(one.faults),
        )
    if taken.reference is None:
        return Came(["it has no reference run"], [])
    return Came(asked.faults(before, taken.reference), [])


@dataclass(frozen=True)
class _OfACapture:
    steps: Callable[[Run], list[str]]
    faults: Callable[[Run, Run], list[str]]


@dataclass(frozen=True)
class _OfAReference:
    steps: Callable[[MeasurementSet], list[str]]
    faults: Callable[[MeasurementSet, Reference], list[str]]


def _asked(kind: str) -> _OfACapture | _OfAReference:
    if kind not in _KINDS:
        raise ValueError(f"no measurement is called {kind!r}; there are: {', '.join(_KINDS)}")
    return _KINDS[kind]


def _first_run(kind: str, before: MeasurementSet) -> Run:
    runs = (
        []
        if before.capture is None
        else runs_of(before.capture, float(before.table.counts_per_rev or 1))
    )
    if not runs:
        raise ValueError(
            f"{kind} is compared with the first run of a capture, but the set has no such run"
        )
    return runs[0]


def _speed(run: Run) -> str:
    return f"{abs(run.speed_deg_s):.3g}°/s"


def _same_way(first: Run, run: Run) -> list[str]:
    return [] if first.way == run.way else [f"it turns {run.way}, expected {first.way}"]


def _same_speed(first: Run, run: Run) -> list[str]:
    ratio = abs(run.speed_deg_s / first.speed_deg_s)
    if abs(ratio - 1.0) <= SAME_SPEED:
        return []
    return [f"it turns at {_speed(run)}, expected the {_speed(first)} of the first run"]


def _whole_turn(run: Run) -> list[str]:
    # The last sample of a captured turn lies one sample before the end of the turn.
    if run.turns + 1.5 / run.samples_a_turn >= 1.0:
        return []
    return [f"it covers {run.turns:.2f} of a turn, expected a whole one"]


def _remarks(kind: str, first: Run, run: Run) -> list[str]:
    if kind == "warm" or first.temperature_c is None or run.temperature_c is None:
        return []
    off = run.temperature_c - first.temperature_c
    if abs(off) <= SAME_TEMPERATURE_K:
        return []
    return [f"it is also {abs(off):.1f} K {'warmer' if off > 0.0 else 'colder'} than the first run"]


def _speed_steps(first: Run) -> list[str]:
    speed = FASTER * abs(first.speed_deg_s)
    return [f"turn the table {first.way} at {speed:.3g}°/s (first run: {_speed(first)})"]


def _speed_faults(first: Run, run: Run) -> list[str]:
    least = ENOUGH * FASTER * abs(first.speed_deg_s)
    faults = [*_same_way(first, run), *_whole_turn(run)]
    if abs(run.speed_deg_s) < least:
        faults.append(f"it turns at {_speed(run)}, expected {least:.3g}°/s or more")
    return faults


def _direction_steps(first: Run) -> list[str]:
    way = "down" if first.way == "up" else "up"
    return [f"turn the table {way} at {_speed(first)} (first run: {first.way})"]


def _direction_faults(first: Run, run: Run) -> list[str]:
    faults = [*_same_speed(first, run), *_whole_turn(run)]
    if run.way == first.way:
        faults.append(f"it turns {run.way} as the first run does, expected the other way")
    return faults


def _again_steps(first: Run) -> list[str]:
    return [
        "let the table stand still for ten minutes",
        f"turn it {first.way} at {_speed(first)}, as in the first run",
    ]


def _again_faults(first: Run, run: Run) -> list[str]:
    return [*_same_way(first, run), *_same_speed(first, run), *_whole_turn(run)]


def _warm_steps(first: Run) -> list[str]:
    now = "" if first.temperature_c is None else f", to {first.temperature_c + WARMER_K:.1f} °C"
    return [
        f"warm the table by {WARMER_K:g} K{now}, and wait until its temperature is steady",
        f"turn it {first.way} at {_speed(first)}, as in the first run",
    ]


def _warm_faults(first: Run, run: Run) -> list[str]:
    faults = _again_faults(first, run)
    if first.temperature_c is None or run.temperature_c is None:
        which = "the set" if first.temperature_c is None else "it"
        return [*faults, f"{which} has no temperature_c, so that its temperature is not known"]
    least = first.temperature_c + ENOUGH * WARMER_K
    if run.temperature_c < least:
        faults.append(f"it is at {run.temperature_c:.1f} °C, expected {least:.1f} °C or more")
    return faults


def _turns_steps(first: Run) -> list[str]:
    return [
        f"turn the table {first.way} at {_speed(first)} for {MORE_TURNS} turns in one recording "
        "(the device keeps one turn: use a recorder that keeps all turns)"
    ]


def _turns_faults(first: Run, run: Run) -> list[str]:
    faults = [*_same_way(first, run), *_same_speed(first, run)]
    if run.turns < ENOUGH * MORE_TURNS:
        faults.append(f"it has {run.turns:.1f} turns, expected {ENOUGH * MORE_TURNS:.0f} or more")
    return faults


def _samples_steps(first: Run) -> list[str]:
    return [
        f"turn the table {first.way} with {MORE_SAMPLES * first.samples_a_turn:,.0f} samples a "
        f"turn (first run: {first.samples_a_turn:,.0f}): use a recorder with a higher rate, or "
        "turn more slowly"
    ]


def _samples_faults(first: Run, run: Run) -> list[str]:
    faults = [*_same_way(first, run), *_whole_turn(run)]
    least = ENOUGH * MORE_SAMPLES * first.samples_a_turn
    if run.samples_a_turn < least:
        faults.append(
            f"it has {run.samples_a_turn:,.0f} samples a turn, expected {least:,.0f} or more"
        )
    return faults


def _faces(before: MeasurementSet) -> int:
    stated = None if before.reference is None else before.reference.faces
    return stated or before.table.faces or FACES


def _targets(reference: Reference) -> NDArray[np.float64]:
    """Return the target angles within a turn, degrees; each angle occurs once."""
    return np.unique(np.round(np.mod(reference.target_deg, 360.0), 3) % 360.0)


def _both_ways(reference: Reference) -> list[str]:
    if reference.direction is None:
        return ["it has no column direction"]
    if np.unique(np.sign(reference.direction)).size < 2:
        return ["its targets are approached from one direction only, expected both"]
    return []


def _reference_steps(before: MeasurementSet) -> list[str]:
    return [
        f"put a polygon of {_faces(before)} faces on the table, and point an autocollimator at it",
        "read each face while the table turns upwards from face to face, then each face while it "
        "turns downwards; repeat this cycle five times or more",
    ]


def _reference_faults(before: MeasurementSet, reference: Reference) -> list[str]:
    there, least = _targets(reference).size, round(ENOUGH * _faces(before))
    faults = _both_ways(reference)
    if there < least:
        faults.append(f"it has {there} targets, expected {least} or more around the turn")
    return faults


def _back_steps(before: MeasurementSet) -> list[str]:
    return [
        "repeat the reference run with every target approached from the other side, "
        "direction = -1 in reference.csv"
    ]


def _back_faults(before: MeasurementSet, reference: Reference) -> list[str]:
    if before.reference is None or before.reference.direction is None:
        return _both_ways(reference)
    if reference.direction is None:
        return ["it has no column direction"]
    new = set(np.sign(reference.direction)) - set(np.sign(before.reference.direction))
    return [] if new else ["its targets are approached from the same side as before"]


def _turned_steps(before: MeasurementSet) -> list[str]:
    third = TURNED_FACES * 360.0 / _faces(before)
    return [
        f"turn the polygon on the table by {third:g}°, a third of a face, and align it again",
        f"repeat the reference run with all targets increased by {third:g}°",
    ]


def _turned_faults(before: MeasurementSet, reference: Reference) -> list[str]:
    if before.reference is None:
        return ["the set has no reference run yet"]
    face_deg = 360.0 / _faces(before)
    old, new = (_phase_deg(rows, face_deg) for rows in (before.reference, reference))
    moved = (new - old) % face_deg / face_deg
    if min(abs(moved - TURNED_FACES), abs(moved - 1.0 + TURNED_FACES)) <= TURNED_WITHIN:
        return []
    return [
        f"its targets are {moved:.2f} of a face away from those of the set, expected "
        f"{TURNED_FACES:.2f} or {1.0 - TURNED_FACES:.2f}"
    ]


def _phase_deg(reference: Reference, face_deg: float) -> float:
    """Return the circular mean of the targets' positions within a polygon face, degrees."""
    turns = np.exp(2j * np.pi * reference.target_deg / face_deg)
    return float(np.angle(turns.mean())) / (2.0 * np.pi) * face_deg


def _reindexed_steps(before: MeasurementSet) -> list[str]:
    return [
        "turn the polygon on the table by one or more whole faces, and align it again",
        "repeat the reference run at the same targets, and store it as a separate set",
    ]


def _reindexed_faults(before: MeasurementSet, reference: Reference) -> list[str]:
    if before.reference is None:
        return ["the set has no reference run yet"]
    old, new = _targets(before.reference), _targets(reference)
    if old.size == new.size and np.allclose(old, new, atol=0.01):
        return []
    return [f"its {new.size} targets are not the {old.size} of the set"]


def _moving_steps(before: MeasurementSet) -> list[str]:
    return [
        "read a reference encoder while the table turns, and record time_s in each row",
        f"turn the table up, then down, then up at {FASTER:g} times the speed, a whole turn each "
        "time",
    ]


def _moving_faults(before: MeasurementSet, reference: Reference) -> list[str]:
    if reference.time_s is None:
        return ["it has no column time_s"]
    run = np.zeros(reference.target_deg.size) if reference.run is None else reference.run
    speeds = [
        (reference.target_deg[end - 1] - reference.target_deg[start])
        / (reference.time_s[end - 1] - reference.time_s[start])
        for start, end in run_spans(run)
        if end - start > 1 and reference.time_s[end - 1] > reference.time_s[start]
    ]
    faults = []
    if not (any(speed > 0.0 for speed in speeds) and any(speed < 0.0 for speed in speeds)):
        faults.append("it lacks a run upwards or a run downwards, expected both")
    sizes = [abs(speed) for speed in speeds if speed]
    if not sizes or max(sizes) < ENOUGH * FASTER * min(sizes):
        faults.append(
            f"its fastest run is less than {ENOUGH * FASTER:g} times as fast as its slowest run"
        )
    return faults


_KINDS: dict[str, _OfACapture | _OfAReference] = {
    "speed": _OfACapture(_speed_steps, _speed_faults),
    "direction": _OfACapture(_direction_steps, _direction_faults),
    "again": _OfACapture(_again_steps, _again_faults),
    "warm": _OfACapture(_warm_steps, _warm_faults),
    "turns": _OfACapture(_turns_steps, _turns_faults),
    "samples": _OfACapture(_samples_steps, _samples_faults),
    "reference": _OfAReference(_reference_steps, _reference_faults),
    "reference_back": _OfAReference(_back_steps, _back_faults),
    "polygon_turned": _OfAReference(_turned_steps, _turned_faults),
    "polygon_reindexed": _OfAReference(_reindexed_steps, _reindexed_faults),
    "moving_reference": _OfAReference(_moving_steps, _moving_faults),
}

KINDS = tuple(_KINDS)
"""Names of the measurements that a diagnosis can request."""
