"""Simulates how samplers and a polygon measure a table with all its causes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arctrue.base.units import ARCSEC_PER_RAD
from arctrue.measurement import Capture, MeasurementSet, Reference, Table
from arctrue.measurement.measurement_set import FURTHER_HEADS
from arctrue.studies.simulate.experiment import (
    CaptureRun,
    Experiment,
    MovingReference,
    ReferencePlan,
)
from arctrue.table.cause import GEOMETRY, Stations, acts_on, refuse_unhonoured
from arctrue.table.causes.index_scatter import IndexScatter
from arctrue.table.conditions import Conditions
from arctrue.table.noise import Noise, together
from arctrue.table.rotary_table import (
    DISC_RADIUS_M,
    GRATING_LINES,
    HEAD_SEPARATION_RAD,
    RotaryTable,
)
from arctrue.table.stations import stations
from arctrue.table.temperature import TemperatureCourse

Float = NDArray[np.float64]

SERVO_ROUNDS = 16
"""Number of iterations of the servo. The largest slope of the error (2.4″ in a signal period) is
0.2, so each iteration divides the remaining distance by 5, and 10⁻¹¹ of the initial 150″ remain."""
MICROSECOND_S = 1e-6
PLACE_DECIMALS = 6
"""Number of decimals of a head's place in degrees; a nominal place has fewer decimals."""
CLOCK_HZ = 100e6


@dataclass(frozen=True)
class TrueNoise:
    """Noise that was drawn for the rows of one channel."""

    gaussian: Noise
    """Gaussian noise of R₂ − R₁ in the capture, which is also that of every other contrast; it
    contains the rounding to counts as white noise with the
    variance count²/12 per head."""
    struck: NDArray[np.bool_]
    """Whether an outlier changed the reading of a head, by row."""


@dataclass(frozen=True)
class Measured:
    """Measurement set with its exact signals and its noise; no model can explain the noise."""

    measurement: MeasurementSet
    floor_arcsec: dict[str, float]
    exact_arcsec: dict[str, Float]
    """R₂ − R₁ − α of every capture row and ε of every reference row, without noise and rounding.

    With three or four heads, all rows of the second contrast follow those of R₂ − R₁, and so on.
    """
    noise: dict[str, TrueNoise]
    """Noise that was drawn for each channel."""
    index_variance_arcsec2: float
    """Variance of R₂ − R₁ between runs that the index marks cause."""


class MeasuredTable:
    """Table with its causes and the random streams of one measurement."""

    def __init__(
        self,
        table: RotaryTable,
        *,
        reference_noise_arcsec: float,
        index_scatter_counts: int,
        random: np.random.Generator,
    ) -> None:
        """Store the table and its causes. ``index_scatter_counts``: largest error, in counts, of a
        head's index in a run."""
        self.table = table
        self.causes = [cause for cause in table.causes if acts_on(cause) - GEOMETRY]
        self.reference_noise_arcsec = reference_noise_arcsec
        self.index = IndexScatter(index_scatter_counts)
        self.random = random
        # Each cause has its own random stream, so that a change of one cause does not change the
        # draws of others.
        self._cause_random = random.spawn(len(self.causes))

    def measure(
        self, experiment: Experiment, *, title: str, drive_gear_teeth: float | None = None
    ) -> Measured:
        """Simulate all measurements that the experiment requires.

        Raises UnhonouredCauseError for a cause that acts on a channel that is not measured.
        """
        refuse_unhonoured(self.table.causes, experiment.honoured, f"experiment {experiment.name}")
        floor: dict[str, float] = {}
        exact: dict[str, Float] = {}
        noise: dict[str, TrueNoise] = {}
        capture = reference = None
        if experiment.runs:
            capture, exact["capture"], floor["capture"], noise["capture"] = self._capture(
                experiment.runs, experiment.temperature
            )
        if experiment.reference is not None:
            reference, exact["reference"], noise["reference"] = self._reference(
                experiment.reference
            )
            floor["reference"] = float(np.std(reference.error_arcsec - exact["reference"]))
        facts = Table(
            counts_per_rev=self.table.counts_per_rev,
            grating_lines=GRATING_LINES,
            disc_diameter_mm=2e3 * DISC_RADIUS_M,
            drive_gear_teeth=drive_gear_teeth,
            **self._head_places(),
        )
        count_arcsec = self.table.count_rad * ARCSEC_PER_RAD
        variance = sum(item.index_variance_counts2() for item in (self.index, *self.causes))
        return Measured(
            MeasurementSet(facts, capture, reference, title),
            floor,
            exact,
            noise,
            2.0 * variance * count_arcsec**2,
        )

    def _capture(
        self, runs: Sequence[CaptureRun], temperature: TemperatureCourse
    ) -> tuple[Capture, Float, float, TrueNoise]:
        motions: list[Conditions] = []
        heads = range(len(self.table.heads))
        white: list[list[Float]] = [[] for _ in heads]
        index: list[list[int]] = [[] for _ in heads]
        travelled_rad = 0.0
        for number, run in enumerate(runs):
            start_rad = float(self.random.uniform(0.0, 2 * np.pi))
            moving = self._moving(run, number, start_rad, travelled_rad, temperature)
            assert moving.travelled_rad is not None
            travelled_rad = float(moving.travelled_rad[-1])
            motions.append(moving)
            for head in heads:
                sigma_counts = self.table.noise_rad / self.table.count_rad
                white[head].append(self.random.normal(0.0, sigma_counts, run.samples))
                index[head].append(self.index.index_shift_counts(self.random))
        state = _joined(motions)
        # Each cause first draws its values for each run, then its values for each row.
        for cause, random in zip(self.causes, self._cause_random, strict=True):
            for number in range(len(runs)):
                for head in heads:
                    index[head][number] += cause.index_shift_counts(random)
        rows = state.time_s.size
        kept = np.ones(rows, dtype=bool)
        struck = np.zeros(rows, dtype=bool)
        processes = [Noise.white(np.sqrt(2.0) * self.table.noise_rad, rows)]
        processes.append(Noise.white(np.sqrt(2.0 / 12.0) * self.table.count_rad, rows))
        places_rad, turns = self._places()
        counts, exact = [], []
        for head in heads:
            shift = np.asarray(index[head])[state.run]
            reading = self.table.reading_rad(head, state) / self.table.count_rad
            reading += turns[head] * self.table.counts_per_rev
            noisy = reading + np.concatenate(white[head])
            for cause, random in zip(self.causes, self._cause_random, strict=True):
                process = cause.head_noise(head, state)
                if process is not None:
                    # All heads have equal noise, so that every contrast has the noise of R₂ − R₁.
                    if head < 2:
                        processes.append(process)
                    noisy = noisy + process.draw(random) / self.table.count_rad
                blow = cause.struck_rad(head, state, random)
                if blow is not None:
                    struck |= blow != 0.0
                    noisy = noisy + blow / self.table.count_rad
            counts.append(self.table.round_counts(noisy) + shift)
            exact.append(reading + shift)
        for cause, random in zip(self.causes, self._cause_random, strict=True):
            recorded = cause.kept_rows(state, random)
            if recorded is not None:
                kept &= recorded
        signal, apart = [], []
        for nominal_rad, true, read in zip(
            contrasts(places_rad), contrasts(exact), contrasts(counts), strict=True
        ):
            signal.append(true[kept] * self.table.count_rad - nominal_rad)
            off = (read - true)[kept]
            apart.append((off - _run_means(off, state.run[kept]))[~struck[kept]])
        noise_rad = np.concatenate(apart) * self.table.count_rad
        capture = Capture(
            state.run[kept],
            state.time_s[kept],
            counts[0][kept],
            counts[1][kept],
            self._shown_temperature(temperature, state)[kept],
            CLOCK_HZ,
            **{name: one[kept] for name, one in zip(FURTHER_HEADS, counts[2:], strict=False)},
        )
        gaussian = together(processes, rows).rows(kept)
        return (
            capture,
            np.concatenate(signal) * ARCSEC_PER_RAD,
            float(np.sqrt(np.mean((noise_rad * ARCSEC_PER_RAD) ** 2))),
            TrueNoise(gaussian, struck[kept]),
        )

    def _places(self) -> tuple[list[float], list[int]]:
        """Return the nominal places of the heads, radians, and the number of turns by which each
        counter is set forward. These turns make its counts lead those of head 1 by the place of its
        head."""
        places = [-head.angle_rad for head in self.table.heads]
        more = len(places) > 2
        turns = [int(more and place < 0.0) for place in places]
        return [place + 2 * np.pi * turn for place, turn in zip(places, turns, strict=True)], turns

    def _head_places(self) -> dict[str, Any]:
        """Return the nominal places of the heads as keys of ``[table]``."""
        if len(self.table.heads) == 2:
            return {"head_separation_deg": float(np.rad2deg(HEAD_SEPARATION_RAD))}
        places = np.rad2deg(self._places()[0])
        return {"head_places_deg": tuple(round(float(at), PLACE_DECIMALS) for at in places)}

    def _shown_temperature(self, course: TemperatureCourse, state: Conditions) -> Float:
        shown = state.temperature_c
        for cause in self.causes:
            lagging = cause.shown_temperature_c(course, state.time_s)
            if lagging is not None:
                shown = lagging
        return shown

    def _moving(
        self,
        run: CaptureRun,
        number: int,
        start_rad: float,
        travelled_rad: float,
        temperature: TemperatureCourse,
    ) -> Conditions:
        # Times are rounded to the file's resolution, a microsecond.
        nominal_s = np.arange(run.samples) * (run.duration_s / run.samples)
        time_s = np.round(nominal_s / MICROSECOND_S) * MICROSECOND_S
        motion = run.motion(start_rad)
        for cause in self.causes:
            motion = cause.driven(motion)
        return replace(
            motion,
            temperature=temperature,
            start_s=run.start_s,
            run=number,
            travelled_rad=travelled_rad,
        ).state(time_s)

    def _reference(self, plan: ReferencePlan) -> tuple[Reference, Float, TrueNoise]:
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
        conditions = stations(time_s, wanted_rad, direction, speed)
        # The angle of each row is computed for a table that stands still, so that a latency of the
        # heads does not change it.
        for _ in range(SERVO_ROUNDS):
            standing = replace(conditions, speed_rad_s=np.zeros_like(speed))
            # The servo brings the reading of head 1, not the table, to the target.
            missing = wanted_rad - self.table.reading_rad(0, standing)
            conditions = conditions.turned(conditions.angle_rad + missing)
        # In motion, the reading that arrives together with the mark was taken before the mark.
        reading = self.table.reading_rad(0, conditions)
        deviation = reading - conditions.angle_rad
        face = np.round(target_deg * plan.faces / 360.0 - turned_faces).astype(np.int64)
        turned_rad = turned_faces * (2 * np.pi / plan.faces)
        seen = Stations(conditions, face % plan.faces, turned_rad)
        instrument: Float | float = 0.0
        for cause in self.causes:
            instrument = instrument + cause.instrument_error_rad(seen, deviation)
        exact_arcsec = (deviation + instrument) * ARCSEC_PER_RAD
        noise = self.random.normal(0.0, self.reference_noise_arcsec, time_s.size)
        processes = [Noise.white(self.reference_noise_arcsec / ARCSEC_PER_RAD, time_s.size)]
        struck = np.zeros(time_s.size, dtype=bool)
        for cause, random in zip(self.causes, self._cause_random, strict=True):
            for process in (cause.head_noise(0, conditions), cause.instrument_noise(seen)):
                if process is not None:
                    processes.append(process)
                    noise = noise + process.draw(random) * ARCSEC_PER_RAD
            blow = cause.struck_rad(0, conditions, random)
            if blow is not None:
                struck |= blow != 0.0
                noise = noise + blow * ARCSEC_PER_RAD
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
        gaussian = together(processes, time_s.size)
        return reference, exact_arcsec, TrueNoise(gaussian, struck)


def contrasts(readings: Sequence[Any]) -> list[Any]:
    """Return √(2(k − 1)/k)·(Rₖ − mean of R₁ … Rₖ₋₁) for the heads k = 2, 3, ….

    If the noise of the heads is independent and equal, the contrasts are independent, and each has
    the noise of R₂ − R₁. Together they contain everything that the differences of the heads show.
    """
    found = []
    for before in range(1, len(readings)):
        mean = sum(readings[1:before], start=readings[0]) / before
        found.append(np.sqrt(2.0 * before / (before + 1)) * (readings[before] - mean))
    return found


def _joined(parts: Sequence[Conditions]) -> Conditions:
    """Join the rows of several runs, in the order of the runs."""
    names = [field.name for field in fields(Conditions)]
    return Conditions(*(np.concatenate([getattr(part, name) for part in parts]) for name in names))


def _run_means(values: Float, run: NDArray[np.int64]) -> Float:
    """Return, for each row, the mean over the row's run, same shape."""
    return np.asarray((np.bincount(run, values) / np.maximum(np.bincount(run), 1))[run])


@dataclass(frozen=True, slots=True)
class _Stations:
    """Stations of a planned reference run, arrays ``(n,)``, and one speed (0 if the table stands at
    each station)."""

    time_s: Float
    cycle: NDArray[np.int64]
    direction: Float
    target_deg: Float
    speed_rad_s: float
    turned_faces: float = 0.0


def _mountings(plan: ReferencePlan) -> list[_Stations]:
    """Return all cycles over the faces, once for each mounting of the polygon on the table."""
    found = []
    up = np.linspace(0.0, 360.0, plan.faces, endpoint=False)
    rows = np.arange(2 * plan.faces * plan.cycles)
    for number, turned_faces in enumerate(plan.turned_faces):
        # A rotation by whole faces does not change the stations; a fraction of a face shifts them.
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
