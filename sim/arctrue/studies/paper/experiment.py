"""Repeats section 4 of the paper on the virtual instrument: ten cycles of 24 faces.

The table turns; the gateware corrects, the firmware calibrates every turn. At every 15° of the
output, the autocollimator reads the polygon's face in front of it. The uncorrected error is the
error of head 1's signal in the same turns; a controller without compensation would use this signal.
"""

from __future__ import annotations

import dataclasses
import time
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arctrue.base.progress import ReportStep
from arctrue.instrument.instrument import Instrument
from arctrue.instrument.recording import EdgeTrack
from arctrue.instrument.run_progress import ReportRun
from arctrue.studies.paper.budget import UncertaintyBudget
from arctrue.studies.paper.published import PUBLISHED, Published
from arctrue.studies.paper.station_error import StationErrors, residual_orders, station_errors
from arctrue.studies.revolution import RevolutionSettings, set_up, settled
from arctrue.table import Motion

Float = NDArray[np.float64]

TURN_RAD = 2.0 * np.pi
KEPT_A_TURN = 1 << 18
"""Number of kept edges in a turn, 5″ apart; the true angle between two kept edges is interpolated
linearly."""


@dataclass(frozen=True, slots=True)
class ExperimentSettings:
    """Settings of the experiment; gateware and table are the same as in ``arctrue revolution``."""

    revolution: RevolutionSettings = dataclasses.field(
        default_factory=lambda: RevolutionSettings(noise_arcsec=0.1)
    )
    cycles: int = PUBLISHED.cycles
    scatter_arcsec: float = 0.08
    """Standard deviation of a reading of the autocollimator. With 0.1″ noise of the heads, a single
    value then has a standard deviation of 0.13″. Ten cycles give 24 estimates of this standard
    deviation; the largest is about the paper's 0.2″."""
    seed: int = 1

    def motion(self) -> Motion:
        """Return the motion: the table passes both indices, then turns for the calibration and the
        ramp, and then makes the cycles."""
        first = self.revolution.motion()
        more_s = self.cycles * TURN_RAD / self.revolution.speed_rad_s
        times = list(first.knot_times_s)
        times[-2:] = [moment + more_s for moment in times[-2:]]
        return dataclasses.replace(first, knot_times_s=tuple(times))


@dataclass(frozen=True, slots=True)
class ExperimentResult:
    """Results of section 4, measured on the virtual instrument."""

    settings: ExperimentSettings
    published: Published
    before: StationErrors
    after: StationErrors
    applied_orders: int
    refused_turns: int
    clocks: int
    wall_s: float

    @property
    def budget(self) -> UncertaintyBudget:
        """Return the uncertainty budget (Table 3) with the repeatability after compensation."""
        return self.after.budget(self.published)

    @property
    def residual_orders_arcsec(self) -> Float:
        """Return the amplitudes of orders 1 to 12 after compensation, as in Fig. 11 b."""
        return residual_orders(self.after.mean_arcsec)

    def as_json(self) -> dict[str, Any]:
        """Return the whole result as plain values."""

        def stations(errors: StationErrors) -> dict[str, Any]:
            return {
                "span_arcsec": list(errors.span_arcsec),
                "mean_arcsec": errors.mean_arcsec.tolist(),
                "deviation_arcsec": errors.deviation_arcsec.tolist(),
            }

        return {
            "settings": dataclasses.asdict(self.settings),
            "published": dataclasses.asdict(self.published),
            "before": stations(self.before),
            "after": stations(self.after),
            "residual_orders_arcsec": self.residual_orders_arcsec.tolist(),
            "budget": {
                **dataclasses.asdict(self.budget),
                "combined_arcsec": self.budget.combined_arcsec,
                "expanded_arcsec": self.budget.expanded_arcsec,
            },
            "applied_orders": self.applied_orders,
            "refused_turns": self.refused_turns,
            "clocks": self.clocks,
            "wall_s": self.wall_s,
        }


def run_experiment(
    settings: ExperimentSettings,
    *,
    published: Published = PUBLISHED,
    report_run: ReportRun | None = None,
    report_step: ReportStep | None = None,
) -> ExperimentResult:
    """Run the paper's experiment on the virtual instrument.

    Raises InstrumentError if tools are missing or the firmware does not reach a swap, ValueError
    for fewer than two cycles.
    """
    if settings.cycles < 2:
        raise ValueError(f"a deviation needs two cycles or more, found {settings.cycles}")
    table = settings.revolution
    random = np.random.default_rng(settings.seed)
    polygon = published.drawn_polygon(random)
    autocollimator = published.drawn_autocollimator(settings.scatter_arcsec, random)
    with Instrument(
        table.lanes,
        table.capture_depth,
        clock_hz=table.clock_hz,
        report_run=report_run,
        report_step=report_step,
    ) as instrument:
        started = time.monotonic()
        instrument.attach(table.table(), settings.motion())
        firmware = set_up(instrument.firmware, table)
        firmware.run(
            until=lambda f: bool(f.telemetry) and settled(instrument, f),
            stage="index, first turn, calibration",
        )
        every = max(1, table.counts_per_rev // KEPT_A_TURN)
        readings: dict[str, list[Float]] = {"head1": [], "output": []}
        for cycle in range(settings.cycles):
            instrument.record(every=every, turns=1.0 + 2.0 / published.faces)
            end = instrument.true_angle_rad + TURN_RAD * (1.0 + 2.0 / published.faces)
            firmware.run(
                until=lambda _, end=end: instrument.true_angle_rad >= end,  # type: ignore[misc]
                stage=f"cycle {cycle + 1} of {settings.cycles}",
            )
            recording = instrument.recording()
            for name, track in (("head1", recording.head1), ("output", recording.output)):
                face, deviation = _stations(track, polygon.faces)
                seen = autocollimator.reading_rad(
                    face, polygon.direction_rad(face, deviation), random
                )
                readings[name].append(seen[np.argsort(face)])
        coefficients = firmware.coefficients
        return ExperimentResult(
            settings=settings,
            published=published,
            before=station_errors(np.array(readings["head1"])),
            after=station_errors(np.array(readings["output"])),
            applied_orders=0
            if coefficients is None
            else int(np.count_nonzero(coefficients.amplitudes)),
            refused_turns=sum(turn["result"] == "refused" for turn in firmware.telemetry),
            clocks=instrument.clock,
            wall_s=time.monotonic() - started,
        )


def _stations(track: EdgeTrack, faces: int) -> tuple[NDArray[np.intp], Float]:
    """Return the numbers of the faces in the order of the turn, and the table's overshoot at each
    face.

    The autocollimator reads a face when the signal reaches the face's angle; the true angle then
    differs by the overshoot. Both arrays have the shape ``(faces,)``. The zero of the overshoot is
    the arbitrary zero of the track.
    """
    counts_per_face = track.counts_per_rev / faces
    first = int(np.ceil(track.true_angle_rad[0] * faces / TURN_RAD))
    numbers = first + np.arange(faces)
    # Positions count from the signal's position at the first face.
    start = np.interp(first * TURN_RAD / faces, track.true_angle_rad, track.position)
    due = np.round(start) + counts_per_face * np.arange(faces)
    stands = np.interp(due, track.position, track.true_angle_rad)
    return numbers % faces, stands - numbers * (TURN_RAD / faces)
