"""Measures a table with all its causes, as samplers and a polygon would."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from arctrue.measurement import Capture, MeasurementSet, Reference, Table
from arctrue.studies.simulate.experiment import (
    CaptureRun,
    Experiment,
    MovingReference,
    ReferencePlan,
)
from arctrue.table.causes.cause import Cause, Stations
from arctrue.table.conditions import USUAL_TEMPERATURE_C, Conditions
from arctrue.table.measurement_set import GRATING_LINES
from arctrue.table.motion import Motion
from arctrue.table.rotary_table import DISC_RADIUS_M, HEAD_SEPARATION_RAD, RotaryTable
from arctrue.units import ARCSEC_PER_RAD

Float = NDArray[np.float64]

SERVO_ROUNDS = 16
"""The slope of the largest error (2.4″ a signal period) is 0.2: each round takes two thirds of a
digit, which leaves 10⁻¹¹ of the first 150″."""
MICROSECOND_S = 1e-6
CLOCK_HZ = 100e6


@dataclass(frozen=True)
class Measured:
    """A measurement set, and the noise in it that no model can explain, RMS by channel."""

    measurement: MeasurementSet
    floor_arcsec: dict[str, float]
    exact_arcsec: dict[str, Float]
    """R₂ − R₁ − α of every capture row and ε of every reference row, neither noise nor rounding."""


class Bench:
    """A table, its causes and the random numbers of one measurement."""

    def __init__(
        self,
        table: RotaryTable,
        *,
        reference_noise_arcsec: float,
        index_scatter_counts: int,
        random: np.random.Generator,
    ) -> None:
        """``index_scatter_counts``: each head takes its index up to so many counts off, a run."""
        self.table = table
        self.causes = [effect for effect in table.effects if isinstance(effect, Cause)]
        self.reference_noise_arcsec = reference_noise_arcsec
        self.index_scatter_counts = index_scatter_counts
        self.random = random

    def measure(
        self, experiment: Experiment, *, title: str, drive_gear_teeth: int | None = None
    ) -> Measured:
        """Everything the experiment asks for."""
        floor: dict[str, float] = {}
        exact: dict[str, Float] = {}
        capture = reference = None
        if experiment.runs:
            capture, exact["capture"], floor["capture"] = self._capture(experiment.runs)
        if experiment.reference is not None:
            reference, exact["reference"] = self._reference(experiment.reference)
            noise = reference.error_arcsec - exact["reference"]
            floor["reference"] = float(np.std(noise))
        facts = Table(
            counts_per_rev=self.table.counts_per_rev,
            grating_lines=GRATING_LINES,
            disc_diameter_mm=2e3 * DISC_RADIUS_M,
            head_separation_deg=float(np.rad2deg(HEAD_SEPARATION_RAD)),
            drive_gear_teeth=drive_gear_teeth,
        )
        return Measured(MeasurementSet(facts, capture, reference, title), floor, exact)

    def reading_rad(self, head: int, conditions: Conditions) -> Float:
        """What head 0 or 1 shows, continuous and without noise, shape ``(n,)``."""
        turn: Float | float = 0.0
        for cause in self.causes:
            turn = turn + cause.disc_turn_rad(conditions)
        reading = self.table.reading_rad(head, conditions.turned(conditions.angle_rad + turn))
        gained = sum(
            (np.asarray(cause.gained_counts(head, conditions)) for cause in self.causes),
            start=np.zeros(1, dtype=np.int64),
        )
        return reading + gained * self.table.count_rad

    def _capture(self, runs: Sequence[CaptureRun]) -> tuple[Capture, Float, float]:
        recorded: list[Capture] = []
        temperatures: list[Float] = []
        differences: list[Float] = []
        unexplained: list[Float] = []
        for number, run in enumerate(runs):
            nominal_s = np.arange(run.samples) * (run.duration_s / run.samples)
            # The file gives times to the microsecond, and the sampler keeps to them.
            time_s = np.round(nominal_s / MICROSECOND_S) * MICROSECOND_S
            share = np.linspace(0.0, 1.0, run.samples)
            first_c, last_c = run.temperature_c
            temperature_c = first_c + share * (last_c - first_c)
            start_rad = float(self.random.uniform(0.0, 2 * np.pi))
            counts, exact = [], []
            for head in (0, 1):
                late_s = sum(cause.sampling_delay_s(head) for cause in self.causes)
                conditions = self._moving(run, number, start_rad, time_s - late_s, temperature_c)
                reading = self.reading_rad(head, conditions) / self.table.count_rad
                noise = self.random.normal(
                    0.0, self.table.noise_rad / self.table.count_rad, reading.size
                )
                scatter = self.index_scatter_counts
                index = int(self.random.integers(-scatter, scatter + 1))
                counts.append(self.table.round_counts(reading + noise) + index)
                exact.append(reading + index)
            temperatures.append(temperature_c)
            recorded.append(
                Capture(
                    np.full(run.samples, number, dtype=np.int64),
                    run.start_s + time_s,
                    counts[0],
                    counts[1],
                )
            )
            differences.append((exact[1] - exact[0]) * self.table.count_rad - HEAD_SEPARATION_RAD)
            apart = (counts[1] - counts[0]) - (exact[1] - exact[0])
            unexplained.append((apart - apart.mean()) * self.table.count_rad * ARCSEC_PER_RAD)
        floor = float(np.sqrt(np.mean(np.concatenate(unexplained) ** 2)))
        capture = Capture(
            np.concatenate([run.run for run in recorded]),
            np.concatenate([run.time_s for run in recorded]),
            np.concatenate([run.head1_counts for run in recorded]),
            np.concatenate([run.head2_counts for run in recorded]),
            np.concatenate(temperatures),
            CLOCK_HZ,
        )
        return capture, np.concatenate(differences) * ARCSEC_PER_RAD, floor

    def _moving(
        self, run: CaptureRun, number: int, start_rad: float, time_s: Float, temperature_c: Float
    ) -> Conditions:
        # The table turns before the first and after the last sample too.
        margin_s = 1.0
        motion = Motion.steady(
            run.speed_rad_s,
            run.duration_s + 2 * margin_s,
            start_rad=start_rad - margin_s * run.speed_rad_s,
        )
        state = motion.state(time_s + margin_s)
        return Conditions(
            run.start_s + time_s,
            state.angle_rad,
            state.speed_rad_s,
            temperature_c,
            np.full(time_s.size, np.sign(run.speed_rad_s)),
            np.full(time_s.size, number, dtype=np.int64),
            time_s,
        )

    def _reference(self, plan: ReferencePlan) -> tuple[Reference, Float]:
        plans = _mountings(plan)
        if plan.moving is not None:
            end_s = float(plans[-1].time_s[-1]) + plan.station_s
            plans += _passes(plan.moving, end_s, int(plans[-1].cycle[-1]) + 1)
        sizes = [item.target_deg.size for item in plans]
        run = np.repeat(np.arange(len(plans)), sizes)
        speed = np.repeat([item.speed_rad_s for item in plans], sizes)
        time_s = np.concatenate([item.time_s for item in plans])
        cycle = np.concatenate([item.cycle for item in plans])
        direction = np.concatenate([item.direction for item in plans])
        target_deg = np.concatenate([item.target_deg for item in plans])
        turned_faces = np.repeat([item.turned_faces for item in plans], sizes)
        wanted_rad = np.deg2rad(target_deg)
        conditions = Conditions(
            time_s,
            wanted_rad,
            speed,
            np.full(time_s.size, USUAL_TEMPERATURE_C),
            direction,
            np.full(time_s.size, -1, dtype=np.int64),
            np.full(time_s.size, np.inf),
        )
        for _ in range(SERVO_ROUNDS):
            # The servo brings the reading of head 1, not the table, to the target.
            missing = wanted_rad - self.reading_rad(0, conditions)
            conditions = conditions.turned(conditions.angle_rad + missing)
        # On the move the reading that arrives with the mark is older than the mark.
        old_s = sum(cause.sampling_delay_s(0) for cause in self.causes)
        before = replace(conditions, angle_rad=conditions.angle_rad - speed * old_s)
        reading = self.reading_rad(0, before)
        deviation = reading - conditions.angle_rad
        face = np.round(target_deg * plan.faces / 360.0 - turned_faces).astype(np.int64)
        turned_rad = turned_faces * (2 * np.pi / plan.faces)
        stations = Stations(conditions, face % plan.faces, turned_rad)
        instrument: Float | float = 0.0
        for cause in self.causes:
            instrument = instrument + cause.instrument_error_rad(stations, deviation)
        exact_arcsec = (deviation + instrument) * ARCSEC_PER_RAD
        noise = self.random.normal(0.0, self.reference_noise_arcsec, time_s.size)
        reference = Reference(
            target_deg=target_deg,
            error_arcsec=exact_arcsec + noise,
            run=run.astype(np.int64),
            time_s=time_s,
            cycle=cycle.astype(np.int64),
            direction=direction.astype(np.int64),
            head1_counts=self.table.round_counts(reading / self.table.count_rad),
            temperature_c=conditions.temperature_c,
            instrument=f"{plan.faces}-sided polygon, electronic autocollimator (simulated)",
            faces=plan.faces,
            standard_uncertainty_arcsec=self.reference_noise_arcsec,
        )
        return reference, exact_arcsec


@dataclass(frozen=True, slots=True)
class _Stations:
    """A reference run as planned: arrays ``(n,)``, one speed (0: the table stands at each)."""

    time_s: Float
    cycle: NDArray[np.int64]
    direction: Float
    target_deg: Float
    speed_rad_s: float
    turned_faces: float = 0.0


def _mountings(plan: ReferencePlan) -> list[_Stations]:
    """All cycles over the faces, once for each way in which the polygon is put on the table."""
    found = []
    up = np.linspace(0.0, 360.0, plan.faces, endpoint=False)
    rows = np.arange(2 * plan.faces * plan.cycles)
    for number, turned_faces in enumerate(plan.turned_faces):
        # Whole faces leave the stations where they are; a part of one shifts them.
        shift_deg = (turned_faces - round(turned_faces)) * 360.0 / plan.faces
        found.append(
            _Stations(
                (number * rows.size + rows) * np.float64(plan.station_s),
                number * plan.cycles + rows // (2 * plan.faces),
                np.where(rows // plan.faces % 2 == 0, 1.0, -1.0),
                np.tile(np.concatenate([up, up[::-1]]), plan.cycles) + shift_deg,
                0.0,
                turned_faces,
            )
        )
    return found


def _passes(moving: MovingReference, start_s: float, first_cycle: int) -> list[_Stations]:
    found = []
    for number, speed_rad_s in enumerate(moving.speeds_rad_s):
        target_deg = np.linspace(0.0, 360.0, moving.stations, endpoint=False)
        if speed_rad_s < 0:
            target_deg = target_deg[::-1]
        passed_rad = np.deg2rad(np.abs(target_deg - target_deg[0]))
        time_s = start_s + 10.0 + passed_rad / abs(speed_rad_s)
        cycle = np.full(target_deg.size, first_cycle + number)
        direction = np.full(target_deg.size, float(np.sign(speed_rad_s)))
        found.append(_Stations(time_s, cycle, direction, target_deg, speed_rad_s))
        start_s = float(time_s[-1])
    return found
