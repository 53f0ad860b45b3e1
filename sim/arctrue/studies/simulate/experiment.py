"""Defines experiments: the runs of a capture, and the stations of a reference run."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from arctrue.table.cause import CAPTURE, REFERENCE, acts_on
from arctrue.table.conditions import USUAL_TEMPERATURE_C
from arctrue.table.declaration import Occasion, Recipe
from arctrue.table.instruments.polygon import FACES
from arctrue.table.motion import Motion
from arctrue.table.registry import CAUSES
from arctrue.table.temperature import TemperatureCourse


@dataclass(frozen=True, slots=True)
class CaptureRun:
    """Run of the capture, at one speed or with a speed profile."""

    start_s: float
    duration_s: float
    speed_rad_s: float
    """Speed with its sign."""
    samples: int
    temperature_c: tuple[float, float] = (USUAL_TEMPERATURE_C, USUAL_TEMPERATURE_C)
    """Temperatures at the first and the last sample; between these the temperature is linear."""

    profile: tuple[tuple[float, float], ...] = ()
    """Speed profile in place of the constant speed: seconds since the start and signed speed at
    each point. The speed is linear between points; the last point must not come before the last
    sample."""

    def motion(self, start_rad: float) -> Motion:
        """Return the motion of the run, which begins at the angle ``start_rad``."""
        if not self.profile:
            return Motion.steady(self.speed_rad_s, self.duration_s, start_rad=start_rad)
        times_s, speeds_rad_s = zip(*self.profile, strict=True)
        return Motion(times_s, speeds_rad_s, start_rad)

    @property
    def last_sample_s(self) -> float:
        """Return the time from the first to the last sample."""
        return self.duration_s * (1.0 - 1.0 / self.samples)


@dataclass(frozen=True, slots=True)
class MovingReference:
    """Passes in which a reference is read while the table moves; each pass is one turn at its own
    speed."""

    speeds_rad_s: tuple[float, ...]
    stations: int = 360


@dataclass(frozen=True, slots=True)
class ReferencePlan:
    """Plan of a reference run: cycles over all faces of a polygon, each up and back."""

    faces: int = FACES
    cycles: int = 10
    station_s: float = 4.0
    moving: MovingReference | None = None
    turned_faces: tuple[float, ...] = (0.0,)
    """Numbers of faces by which the polygon is turned on the table; for each entry, all cycles are
    measured once."""


@dataclass(frozen=True, slots=True)
class Experiment:
    """Runs of a capture, and the plan of a reference run or None."""

    name: str
    runs: tuple[CaptureRun, ...]
    reference: ReferencePlan | None

    def smaller(self, samples: int, cycles: int) -> Experiment:
        """Return the same experiment with fewer samples per run and fewer cycles."""
        reference = None if self.reference is None else replace(self.reference, cycles=cycles)
        return Experiment(
            self.name, tuple(replace(run, samples=samples) for run in self.runs), reference
        )

    @property
    def honoured(self) -> frozenset[str]:
        """Return the names of the methods of a cause that a channel of this experiment
        evaluates."""
        nothing: frozenset[str] = frozenset()
        return (CAPTURE if self.runs else nothing) | (REFERENCE if self.reference else nothing)

    def can_honour(self, recipe: Recipe) -> bool:
        """Tell whether the channels of the experiment evaluate every method that the cause
        overrides."""
        return acts_on(CAUSES[recipe.cause].kind) <= self.honoured

    @property
    def occasion(self) -> Occasion:
        """Return the properties of the runs on which the draw of a cause may depend."""
        return Occasion(
            tuple(run.start_s for run in self.runs),
            tuple(run.duration_s for run in self.runs),
            tuple(run.speed_rad_s for run in self.runs),
        )

    @property
    def temperature(self) -> TemperatureCourse:
        """Return the temperature over all runs; it is linear also in the pauses."""
        knots = [
            (run.start_s + share * run.last_sample_s, run.temperature_c[share])
            for run in self.runs
            for share in (0, 1)
        ]
        if not knots:
            return TemperatureCourse()
        times_s, temperatures_c = zip(*knots, strict=True)
        return TemperatureCourse(times_s, temperatures_c)


TURNS = 3
SAMPLES = 18_000
SLOW_RAD_S = 2 * np.pi / 12.0


def _run(
    start_s: float, speed_rad_s: float, temperature_c: tuple[float, float] | None = None
) -> CaptureRun:
    usual = (USUAL_TEMPERATURE_C, USUAL_TEMPERATURE_C)
    duration_s = TURNS * 2 * np.pi / abs(speed_rad_s)
    return CaptureRun(start_s, duration_s, speed_rad_s, SAMPLES, temperature_c or usual)


def full() -> Experiment:
    """Return four runs (up, down, three times as fast, warm after half an hour) and ten polygon
    cycles."""
    runs = (
        _run(0.0, SLOW_RAD_S),
        _run(60.0, -SLOW_RAD_S),
        _run(120.0, 3 * SLOW_RAD_S),
        _run(1800.0, SLOW_RAD_S, (USUAL_TEMPERATURE_C + 3.5, USUAL_TEMPERATURE_C + 4.5)),
    )
    return Experiment("full", runs, ReferencePlan())


def lean() -> Experiment:
    """Return one run without a reference."""
    return Experiment("lean", (_run(0.0, SLOW_RAD_S),), None)


def one_pass() -> Experiment:
    """Return one turn upwards, and one cycle over the faces of a polygon."""
    run = replace(_run(0.0, SLOW_RAD_S), duration_s=2 * np.pi / SLOW_RAD_S)
    return Experiment("one_pass", (run,), ReferencePlan(cycles=1))


def one_speed() -> Experiment:
    """Return four runs up and down at one speed and one temperature, and ten polygon cycles."""
    runs = tuple(_run(60.0 * number, SLOW_RAD_S * (1 - 2 * (number % 2))) for number in range(4))
    return Experiment("one_speed", runs, ReferencePlan())


def short() -> Experiment:
    """Return the full experiment with a sixth of the samples, which is quick to make and to
    diagnose."""
    return replace(full().smaller(SAMPLES // 6, cycles=10), name="short")


FURTHER_PAUSE_S = 600.0
FURTHER_TURNS = 30
FURTHER_SAMPLES = 5
"""Factor by which the further run ``samples`` has more samples per turn than the other runs."""
FURTHER_WARMER_C = 4.0
FURTHER_TURNED_FACES = 1.0 / 3.0
FURTHER_REINDEXED_FACES = 6.0


def with_further(experiment: Experiment, kind: str) -> Experiment:
    """Return the experiment with one more measurement, of a kind that a diagnosis may request.

    Raises ValueError for an unknown kind, or for a kind that does not fit this experiment.
    """
    if kind not in FURTHER:
        raise ValueError(f"no further measurement {kind!r}; there are: {', '.join(FURTHER)}")
    name = f"{experiment.name}+{kind}"
    if kind in ("reference", "polygon_turned", "polygon_reindexed", "moving_reference"):
        plan = experiment.reference or ReferencePlan()
        if kind == "polygon_turned":
            plan = replace(plan, turned_faces=(*plan.turned_faces, FURTHER_TURNED_FACES))
        if kind == "polygon_reindexed":
            # The reference file has no key for the rotation of the polygon, so the measurement
            # becomes a separate set.
            plan = replace(plan, turned_faces=(FURTHER_REINDEXED_FACES,))
        if kind == "moving_reference":
            plan = replace(plan, moving=MovingReference((SLOW_RAD_S, -SLOW_RAD_S, 3 * SLOW_RAD_S)))
        return Experiment(name, experiment.runs, plan)
    if not experiment.runs:
        raise ValueError(f"a further run {kind!r} needs a capture")
    return Experiment(
        name, (*experiment.runs, _further_run(experiment, kind)), experiment.reference
    )


def _further_run(experiment: Experiment, kind: str) -> CaptureRun:
    first, last = experiment.runs[0], experiment.runs[-1]
    run = replace(first, start_s=last.start_s + last.duration_s + FURTHER_PAUSE_S)
    if kind == "speed":
        return replace(run, speed_rad_s=3 * run.speed_rad_s, duration_s=run.duration_s / 3)
    if kind == "direction":
        return replace(run, speed_rad_s=-run.speed_rad_s)
    if kind == "warm":
        cold, warm = run.temperature_c
        return replace(run, temperature_c=(cold + FURTHER_WARMER_C, warm + FURTHER_WARMER_C))
    if kind == "turns":
        more = FURTHER_TURNS / TURNS
        return replace(run, duration_s=run.duration_s * more, samples=round(run.samples * more / 2))
    if kind == "samples":
        return replace(run, samples=FURTHER_SAMPLES * run.samples)
    return run


FURTHER = (
    "speed",
    "direction",
    "warm",
    "again",
    "turns",
    "samples",
    "reference",
    "polygon_turned",
    "polygon_reindexed",
    "moving_reference",
)
"""Kinds of a further measurement. A further capture run is three times as fast, in the other
direction, warmer, a repetition after a stop, longer, or with more samples. A further reference run
is the first reference run of the set, has the polygon turned by a third of a face, has it turned by
whole faces (as a separate set), or is read in motion."""

EXPERIMENTS = {
    "full": full,
    "lean": lean,
    "one_pass": one_pass,
    "one_speed": one_speed,
    "short": short,
}
