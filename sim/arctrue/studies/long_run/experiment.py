"""Runs one long scenario with several ways of correction and compares the remaining errors."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Sequence
from typing import Any

import numpy as np
from msgspec import structs
from numpy.typing import NDArray

from arctrue.base.progress import ReportStep
from arctrue.base.units import arcsec_per_count
from arctrue.instrument import ReportRun
from arctrue.metrology.allan import overlapping_allan_deviation
from arctrue.metrology.trend import TrendWatch
from arctrue.studies.long_run.learned_model import (
    LearnedOrder,
    as_coefficients,
    learn,
    telemetry_orders,
)
from arctrue.studies.long_run.truth import Truth
from arctrue.studies.scenario import Scenario, ScenarioResult, run_scenario

Float = NDArray[np.float64]

LEARNED_PART = 0.45
"""Share of the turns, from the beginning of the run, to which the temperature model is fitted."""
AVERAGE_KEEP = 0.8
"""Default value of the firmware's parameter ``keep``."""
DECIMALS = 4
"""Number of decimals of the values of each turn, in ″ and °C."""
STRATEGIES = {
    "held": "calibrated in the first turn only",
    "single": "calibrated from every single turn",
    "average": "calibrated from a running average of the turns (keep 0.8)",
    "model": "orders that depend on temperature by a model, the others by a running average",
}


def shortened(scenario: Scenario, turns: float) -> Scenario:
    """Return the scenario with fewer turns; temperatures and faults stay at about the same share of
    the run.

    Raises ValueError for a scenario that is not one leg of turns.
    """
    if len(scenario.legs) != 1 or not scenario.legs[0].turns:
        raise ValueError("a long run must have one leg of turns and no pause")
    (leg,) = scenario.legs
    factor = turns / abs(leg.turns)
    return dataclasses.replace(
        scenario,
        legs=(dataclasses.replace(leg, turns=leg.turns * factor),),
        temperature=tuple(
            structs.replace(point, at_turn=point.at_turn * factor) for point in scenario.temperature
        ),
        faults=tuple(
            dataclasses.replace(fault, at_turn=np.floor(fault.at_turn * factor) + fault.at_turn % 1)
            for fault in scenario.faults
        ),
    )


def run_long(
    scenario: Scenario,
    *,
    strategies: Sequence[str] = tuple(STRATEGIES),
    report_run: ReportRun | None = None,
    report_step: ReportStep | None = None,
) -> dict[str, Any]:
    """Run the scenario once for each strategy of correction; return the results as plain values.

    The strategy ``single`` always runs, because the Allan deviation and the temperature model need
    turns that are calibrated independently of each other. Raises InstrumentError if the instrument
    cannot run, and ValueError if the turns for the fit do not determine the model.
    """
    begun = time.process_time()
    telemetry: dict[str, list[dict[str, Any]]] = {}
    found: dict[str, ScenarioResult] = {}
    learned: list[LearnedOrder] = []
    reference_c = 20.0
    for name in ("single", *(name for name in strategies if name != "single")):
        if report_step is not None:
            report_step(f"{name}: {STRATEGIES[name]}")
        wanted = _by_strategy(scenario, name)
        if name == "model":
            learned, reference_c = _learned(found["single"], telemetry["single"])
            bank = as_coefficients(
                learned, reference_c, scenario.scale.counts_per_rev, scenario.scale.lanes
            )
            wanted = dataclasses.replace(
                wanted,
                firmware=dataclasses.replace(wanted.firmware, loaded=bank, thermometer=True),
            )
        result = run_scenario(wanted, report_run=report_run, report_step=report_step)
        telemetry[name] = [one for turn in result.turns for one in turn.telemetry]
        found[name] = result
    truth = Truth(scenario)
    last = round(LEARNED_PART * len(found["single"].turns))
    return {
        "schema": 1,
        "title": scenario.title,
        "about": scenario.about.strip(),
        "turns": len(found["single"].turns),
        "counts_per_rev": scenario.scale.counts_per_rev,
        "samples": scenario.scale.samples,
        "lanes": scenario.scale.lanes,
        "noise_arcsec": scenario.errors.noise_arcsec,
        "orders": scenario.firmware.orders,
        "turn_s": 2.0 * np.pi / scenario.speeds_rad_s[0],
        "learned_turns": last,
        "temperature_c": np.round([turn.temperature_c for turn in found["single"].turns], DECIMALS),
        "events": {
            str(turn.number): list(turn.events) for turn in found["single"].turns if turn.events
        },
        "strategies": {
            name: _scored(found[name], truth, last) for name in STRATEGIES if name in found
        },
        "model": {
            "reference_c": reference_c,
            "orders": [
                {
                    "order": one.order,
                    "slope_arcsec_per_k": abs(one.slope_arcsec_per_k),
                    "u_arcsec_per_k": one.u_slope_arcsec_per_k,
                }
                for one in learned
            ],
        },
        "allan": _allan(telemetry["single"], len(found["single"].turns), scenario.orders),
        "trends": _trends(telemetry["single"]),
        "uncorrected_rms_arcsec": np.round(
            [_rms(truth.error_arcsec(turn.number)) for turn in found["single"].turns], DECIMALS
        ),
        "clocks": sum(result.clocks for result in found.values()),
        "cpu_s": time.process_time() - begun,
    }


def _by_strategy(scenario: Scenario, name: str) -> Scenario:
    given = dict(scenario.firmware.parameters)
    given["keep"] = 0.0 if name in ("held", "single") else AVERAGE_KEEP
    firmware = dataclasses.replace(
        scenario.firmware,
        recalibrate="first_turn" if name == "held" else "every_turn",
        parameters=tuple(given.items()),
    )
    return dataclasses.replace(scenario, firmware=firmware)


def _learned(
    result: ScenarioResult, telemetry: Sequence[dict[str, Any]]
) -> tuple[list[LearnedOrder], float]:
    """Fit the temperature model; return the model, and the reference temperature at which its
    constant part applies."""
    turns, values = telemetry_orders(telemetry)
    first = turns <= round(LEARNED_PART * len(result.turns))
    celsius = np.array([turn.temperature_c for turn in result.turns])[turns - 1]
    reference_c = round(float(celsius[first].mean()), 3)
    return learn(turns[first], values[first], celsius[first], reference_c), reference_c


def _scored(result: ScenarioResult, truth: Truth, learned_turns: int) -> dict[str, Any]:
    """Return, for each turn, the error that remains after a correction by the coefficients, and the
    error of the core's output."""
    telemetry = [one for turn in result.turns for one in turn.telemetry]
    left = np.array([truth.left_arcsec(turn) for turn in result.turns])
    worst = SETTLED_TURNS + int(np.argmax(left[SETTLED_TURNS:]))
    output = [
        np.nan if turn.corrected is None else turn.corrected.rms_arcsec for turn in result.turns
    ]
    mean = [
        np.nan if turn.corrected is None else turn.corrected.mean_arcsec for turn in result.turns
    ]
    refused = {
        str(turn.number): one["reason"]
        for turn in result.turns
        for one in turn.telemetry
        if one["result"] == "refused"
    }
    alarms = {
        str(turn.number): sorted({alarm for one in turn.telemetry for alarm in one["alarms"]})
        for turn in result.turns
        if any(one["alarms"] for one in turn.telemetry)
    }
    return {
        "left_arcsec": np.round(left, DECIMALS),
        "mean_arcsec": np.round(mean, DECIMALS),
        "rms_arcsec": _rms(left[SETTLED_TURNS:]),
        "rms_after_learning_arcsec": _rms(left[max(SETTLED_TURNS, learned_turns) :]),
        "largest_arcsec": float(left[worst]),
        "largest_turn": worst + 1,
        "largest_orders": _applied(result, worst),
        "output_rms_median_arcsec": float(np.nanmedian(output[SETTLED_TURNS:])),
        "applied": sum(one["result"] == "applied" for one in telemetry),
        "refused": refused,
        "alarms": alarms,
    }


def _applied(result: ScenarioResult, place: int) -> dict[str, float]:
    """Return the amplitude, in arcseconds, of each order that the coefficients at the end of a turn
    correct."""
    bank = result.turns[place].bank
    if bank is None:
        return {}
    count = arcsec_per_count(result.scenario.scale.counts_per_rev)
    return {
        str(order): float(amplitude) * count
        for order, amplitude in zip(bank.orders.tolist(), bank.amplitudes_counts, strict=True)
        if amplitude
    }


SETTLED_TURNS = 2
"""Number of turns that are not scored: the first captured turn, and the turn of the ramp."""


def _rms(values: Float) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _allan(
    telemetry: Sequence[dict[str, Any]], turns: int, orders: Sequence[int]
) -> dict[str, Any]:
    """Return the Allan deviation of each listed order: the root of the mean of the Allan variances
    of cosine and sine."""
    numbers, values = telemetry_orders(telemetry)
    series = np.full((turns + 1, values.shape[1]), np.nan, dtype=np.complex128)
    series[numbers[numbers <= turns]] = values[numbers <= turns]
    series = series[1:]
    most = turns // 3
    averaged = np.unique(np.rint(np.geomspace(1, most, 25)).astype(np.int64))
    uncertainty = {
        str(order): float(
            np.median([one["harmonics"][order - 1][3] for one in telemetry if one.get("harmonics")])
        )
        for order in orders
    }
    found = {}
    for order in orders:
        column = series[:, order - 1]
        both = [
            overlapping_allan_deviation(part, averaged)[0] for part in (column.real, column.imag)
        ]
        found[str(order)] = np.sqrt((both[0] ** 2 + both[1] ** 2) / 2.0)
    return {"averaged_turns": averaged, "deviation_arcsec": found, "u_arcsec": uncertainty}


def _trends(telemetry: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """List the trends in the telemetry that ``arctrue monitor`` would report."""
    watch = TrendWatch()
    found = []
    for one in telemetry:
        for trend in watch.add(int(one["turn"]), one.get("harmonics", [])):
            found.append(
                {
                    "turn": int(one["turn"]),
                    "order": trend.order,
                    "change_arcsec": trend.change_arcsec,
                    "turns": trend.turns,
                    "u_arcsec": trend.u_arcsec,
                }
            )
    return found
