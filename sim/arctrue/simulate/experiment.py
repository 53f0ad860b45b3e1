"""What is measured: the runs of a capture and the stations of a reference run."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from arctrue.table.conditions import USUAL_TEMPERATURE_C


@dataclass(frozen=True, slots=True)
class CaptureRun:
    """One run of the capture at one speed."""

    start_s: float
    duration_s: float
    speed_rad_s: float
    """Signed."""
    samples: int
    temperature_c: tuple[float, float] = (USUAL_TEMPERATURE_C, USUAL_TEMPERATURE_C)
    """At the first and the last sample; straight in between."""


@dataclass(frozen=True, slots=True)
class MovingReference:
    """Passes over a reference that is read on the move, one turn a speed."""

    speeds_rad_s: tuple[float, ...]
    stations: int = 360


@dataclass(frozen=True, slots=True)
class ReferencePlan:
    """Cycles over all faces, up and back."""

    faces: int = 24
    cycles: int = 10
    station_s: float = 4.0
    moving: MovingReference | None = None


@dataclass(frozen=True, slots=True)
class Experiment:
    """Runs and a reference run (or none)."""

    name: str
    runs: tuple[CaptureRun, ...]
    reference: ReferencePlan | None

    def smaller(self, samples: int, cycles: int) -> Experiment:
        """The same with fewer samples a run and fewer cycles."""
        reference = None if self.reference is None else replace(self.reference, cycles=cycles)
        return Experiment(
            self.name, tuple(replace(run, samples=samples) for run in self.runs), reference
        )


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
    """Up, down, three times as fast, and warm after half an hour; then ten polygon cycles."""
    runs = (
        _run(0.0, SLOW_RAD_S),
        _run(60.0, -SLOW_RAD_S),
        _run(120.0, 3 * SLOW_RAD_S),
        _run(1800.0, SLOW_RAD_S, (USUAL_TEMPERATURE_C + 3.5, USUAL_TEMPERATURE_C + 4.5)),
    )
    return Experiment("full", runs, ReferencePlan())


def lean() -> Experiment:
    """One run, and nothing else."""
    return Experiment("lean", (_run(0.0, SLOW_RAD_S),), None)


def short() -> Experiment:
    """The full one with a third of the samples: quick to make and to judge."""
    return replace(full().smaller(SAMPLES // 3, cycles=10), name="short")


EXPERIMENTS = {"full": full, "lean": lean, "short": short}
