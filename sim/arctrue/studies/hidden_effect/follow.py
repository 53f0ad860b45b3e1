"""Compares, turn by turn, four ways to correct thermal eccentricity while the table warms."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from arctrue.instrument import Instrument, InstrumentError, ReportRun
from arctrue.instrument.turn_score import score_turn
from arctrue.studies.hidden_effect.cases import COLD_C, WARM_C
from arctrue.studies.hidden_effect.drive import turning
from arctrue.studies.hidden_effect.result import HiddenResult
from arctrue.studies.hidden_effect.rig import Rig
from arctrue.table import Motion

HELD, EVERY_TURN, BY_TEMPERATURE, BY_FIRMWARE = WAYS = (
    "held",
    "every turn",
    "by temperature",
    "by the firmware",
)
"""Ways of correction: (1) the coefficients of the first turn are never changed; (2) the firmware
calibrates after each turn; (3) the host writes the model's coefficients for the present
temperature; (4) the model is loaded once over the console, and the firmware evaluates the model at
the temperature of its thermometer."""


JUDGED_TURNS = 1.4


@dataclass(frozen=True, slots=True)
class FollowedTurn:
    """Result of one turn of the corrected output while the table warms."""

    temperature_c: float
    """Temperature in the middle of the turn."""
    order1_arcsec: float
    rms_arcsec: float


def follow_warming(
    result: HiddenResult,
    turns: int,
    *,
    ways: Sequence[str] = WAYS,
    sensor_lag_s: float = 0.0,
    stated_lag_s: float | None = None,
    report_run: ReportRun | None = None,
) -> dict[str, list[FollowedTurn]]:
    """Measure the table of ``result`` while it warms over ``turns`` turns, once for each way of
    correction.

    The thermometer lags by ``sensor_lag_s``; the coefficient file states ``stated_lag_s``, by
    default the same value. Raises InstrumentError if the firmware does not reach a swap.
    """
    scale = result.settings.revolution
    found = {}
    lags = (sensor_lag_s, sensor_lag_s if stated_lag_s is None else stated_lag_s)
    for way in ways:
        with Instrument(
            scale.lanes, scale.capture_depth, clock_hz=scale.clock_hz, report_run=report_run
        ) as instrument:
            table = result.settings.table(result.case.build(result.settings))
            rig = Rig(instrument, table, result.settings)
            found[way] = _followed(rig, result, way, turns, lags)
    return found


def _followed(
    rig: Rig, result: HiddenResult, way: str, turns: int, lags: tuple[float, float]
) -> list[FollowedTurn]:
    scale = result.settings.revolution
    # A recording is slightly longer than a turn, and the new coefficients take some time to fade
    # in.
    every = 1.0 + 1.4 * turns
    # The firmware needs an additional turn to test the loaded model; the table warms at the usual
    # rate meanwhile.
    driven = every + (JUDGED_TURNS if way == BY_FIRMWARE else 0.0)
    drive = turning(
        scale.speed_rad_s,
        driven,
        ripple_rad=scale.ripple_rad,
        ripple_order=scale.ripple_order,
        temperature_c=(COLD_C, COLD_C + (WARM_C - COLD_C) * driven / every),
    )
    firmware = rig.instrument.firmware
    # An average over turns would lag behind the changing table.
    firmware.set("keep", 0.0)
    rig.power_up(drive, frozen=False, stage=f"{way}: indices")
    if way == BY_FIRMWARE:
        firmware.thermometer = _thermometer(rig, drive, lags[0])
    rig.captured_turn(f"{way}: first turn")
    if firmware.telemetry[-1]["result"] != "applied":
        raise InstrumentError(
            f"the firmware did not apply the first turn: {firmware.telemetry[-1]}"
        )
    if way not in (EVERY_TURN, BY_FIRMWARE):
        firmware.send("freeze on")
    rig.settle(way)
    if way == BY_FIRMWARE:
        export = result.diagnosed.export(scale.lanes, None, lags[1])
        rig.load_over_console(export.coefficients, f"{way}: judged")
    found = []
    for _ in range(turns):
        if way == BY_TEMPERATURE:
            ahead_c = _middle_c(rig, drive)
            export = result.diagnosed.export(scale.lanes, ahead_c)
            rig.load(export.coefficients, way)
        temperature_c = _middle_c(rig, drive)
        recording = rig.recorded_turn(way)
        seen = score_turn(recording.output)
        order1 = float(seen.amplitude_arcsec[0])
        found.append(FollowedTurn(temperature_c, order1, seen.edges_rms_arcsec))
    return found


def _thermometer(rig: Rig, drive: Motion, lag_s: float) -> Callable[[], float]:
    """Return a function that reads a simulated thermometer on the table; it has a resolution of
    1/128 K, like ADT7420 and TMP117."""

    def shown() -> float:
        now_s = rig.motion_time_s(np.array([float(rig.instrument.clock)]))
        if lag_s == 0.0:
            celsius = drive.temperature_c(now_s)
        else:
            celsius = drive.temperature.lagging(drive.start_s + drive.surroundings_at(now_s), lag_s)
        return float(np.rint(celsius[0] * 128.0) / 128.0)

    return shown


def _middle_c(rig: Rig, drive: Motion) -> float:
    """Return the temperature of the table half a turn from now, or at the end of the motion if this
    comes first."""
    scale = rig.settings.revolution
    now_s = rig.motion_time_s(np.array([float(rig.instrument.clock)]))
    half_s = np.pi / scale.speed_rad_s
    return float(drive.temperature_c(np.minimum(now_s + half_s, drive.duration_s))[0])
