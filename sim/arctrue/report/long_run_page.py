"""Makes the page of ``arctrue long-run`` from its result."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from arctrue.base.percent import percent
from arctrue.base.units import arcsec_per_count
from arctrue.report.charts.long_run_picture import PICTURE, SAID
from arctrue.report.numbers import decimal

SHOWN_LENGTHS = (1, 4, 16, 64, 256)


def long_run_page(found: Mapping[str, Any]) -> str:
    """Return the page as Markdown."""
    hours = found["turns"] * found["turn_s"] / 3600.0
    count = arcsec_per_count(found["counts_per_rev"])
    rounding = count / np.sqrt(12.0)
    celsius = found["temperature_c"]
    raw = found["uncorrected_rms_arcsec"]
    learned = found["learned_turns"]
    return "\n".join(
        [
            "# Long run",
            "",
            f"`arctrue long-run` simulates {found['turns']:,} turns of a table, {hours:.1f} hours. "
            "The table warms and cools, its disc creeps on the hub, and head 1 once loses counts.",
            "This page shows how the orders drift and which strategy of recalibration follows the "
            "drift. The command makes the page from [long-run.json](data/long-run.json).",
            "",
            "```sh",
            ".venv/bin/arctrue long-run sim/scenarios/long_run.toml --page docs/long-run.md "
            f"--json docs/data/long-run.json --out docs/images   # {found['cpu_s'] / 60:.0f} "
            "minutes of one core",
            ".venv/bin/arctrue long-run sim/scenarios/long_run.toml --turns 60     # a quick look",
            "```",
            "",
            "**Set-up.** The [virtual instrument](instrument.md) has "
            f"{found['lanes']} lanes and {found['counts_per_rev']:,} counts per turn "
            f"({count:.0f}″ each). Every edge passes through the compiled",
            "gateware. In every turn the firmware's C code captures and calibrates, loads the "
            "coefficients and swaps the banks over the bus; the run takes "
            f"{found['clocks'] / 1e6:,.0f} million clocks.",
            "No board was used. The scenario is "
            "[sim/scenarios/long_run.toml](../sim/scenarios/long_run.toml):",
            "",
            *(f"> {line}" for line in found["about"].splitlines()),
            "",
            "## Recalibration compared with a model",
            "",
            "*Remaining* is the RMS of the remaining error over the turns from turn 3 on. The "
            "remaining error of a turn is the table's true error (from its geometry, without "
            "noise),",
            "minus the correction that is active at the end of the turn. The uncorrected error is "
            f"{min(raw):.0f}″ to {max(raw):.0f}″ RMS, at {min(celsius):.1f} °C to "
            f"{max(celsius):.1f} °C.",
            "",
            f"| Strategy | Remaining, ″ | Remaining from turn {learned + 1} on, ″ | Largest "
            "in a turn, ″ | Calibrations applied | Calibrations refused |",
            "|---|---:|---:|---:|---:|---:|",
            *(
                f"| {SAID[name]} | {one['rms_arcsec']:.2f} | "
                f"{one['rms_after_learning_arcsec']:.2f} | {one['largest_arcsec']:.2f} | "
                f"{one['applied']} | {len(one['refused'])} |"
                for name, one in found["strategies"].items()
            ),
            "",
            f"![Temperature, remaining error, Allan deviation](images/{PICTURE})",
            "",
            *_model(found),
            "- A calibration from a single turn is noisy: with counts of "
            f"{count:.0f}″ and {found['samples']} samples, order 1 has a standard uncertainty of "
            f"{found['allan']['u_arcsec']['1']:.1f}″",
            "  (some thousandths of an arcsecond with 2²⁴ counts and 12,000 samples). A running "
            "average has less noise, but follows a change with a lag of some turns.",
            "- The firmware keeps the active coefficients if it expects no smaller error from the "
            "new coefficients; therefore it does not apply the calibration of every turn.",
            f"- The edges of the output deviate by {_median_output(found):.0f}″ RMS with each "
            "recalibrating strategy: the output changes only at edges of head 1, so the output is",
            f"  rounded to a count, and a count/√12 is {rounding:.0f}″.",
            "",
            *_allan(found),
            *_trends(found),
            *_fault(found),
        ]
    )


def _median_output(found: Mapping[str, Any]) -> float:
    values = [
        one["output_rms_median_arcsec"]
        for name, one in found["strategies"].items()
        if name != "held"
    ]
    return float(np.mean(values))


def _model(found: Mapping[str, Any]) -> list[str]:
    orders = ", ".join(
        f"order {one['order']}: {one['slope_arcsec_per_k']:.2f}″/K (u = "
        f"{one['u_arcsec_per_k']:.2f}″/K)"
        for one in found["model"]["orders"]
    )
    if "model" not in found["strategies"]:
        return []
    return [
        "- The temperature model is fitted to the telemetry of turns 1 to "
        f"{found['learned_turns']}, by least squares with a constant, the temperature and the turn "
        f"number as regressors ({orders}).",
        "  The model is loaded into lanes that [follow the temperature]"
        "(firmware-load.md#lanes-that-follow-the-temperature), which a thermometer on the table "
        "measures in steps of 1/128 K. At temperatures above those of the fit, the model "
        "extrapolates.",
        "- The model's correction has no noise and no lag, but follows only the temperature. In "
        "turns 3 to "
        f"{found['learned_turns']}, {_part(found, 'model', first=True):.2f}″ remain with the "
        f"model and {_part(found, 'average', first=True):.2f}″ with the running average. In the",
        "  last hundred turns, after the disc has crept further, "
        f"{_part(found, 'model', first=False):.2f}″ remain with the model and "
        f"{_part(found, 'average', first=False):.2f}″ with the running average.",
        "- Recalibration needs no model of the table and follows every change as fast as the "
        "noise of a turn allows. The firmware combines model and recalibration:",
        "  the orders in the model's file follow the model, all other orders follow the "
        "calibration. Fit the model again if the table changes for another reason than "
        "temperature.",
        *_worst(found),
    ]


def _part(found: Mapping[str, Any], name: str, *, first: bool) -> float:
    """Return the RMS error of the turns used for learning, from turn 3 on (``first``), or of the
    last hundred turns."""
    left = np.asarray(found["strategies"][name]["left_arcsec"], dtype=np.float64)
    part = left[2 : found["learned_turns"]] if first else left[-100:]
    return float(np.sqrt(np.mean(part**2)))


def _worst(found: Mapping[str, Any]) -> list[str]:
    """Return sentences about the orders that are corrected in the worst turn of the run that is
    calibrated from single turns."""
    one = found["strategies"]["single"]
    orders = " and ".join(
        f"{order} ({amplitude:.0f}″)" for order, amplitude in one["largest_orders"].items()
    )
    said = [
        "- With calibration from every single turn, the largest error remains in turn "
        f"{one['largest_turn']}. The largest orders of the correction in this turn are {orders}."
    ]
    if WEAK_ORDER in one["largest_orders"]:
        said += [
            "  The firmware also applies an order if noise alone lifts its amplitude above the "
            "significance limit; in 5 % of turns this happens to at least one order. Two heads "
            "33° apart determine",
            f"  order {WEAK_ORDER} with a noise gain of 19, so that noise causes a large false "
            "amplitude of this order. "
            "Averaging makes such turns rare; `set orders 10` or another "
            "[angle between the heads](head-angle.md) prevents them.",
        ]
    return said


WEAK_ORDER = "11"


def _allan(found: Mapping[str, Any]) -> list[str]:
    allan = found["allan"]
    lengths = allan["averaged_turns"]
    columns = [int(np.argmin([abs(m - wanted) for m in lengths])) for wanted in SHOWN_LENGTHS]
    columns = [place for place in dict.fromkeys(columns) if lengths[place] <= found["turns"] // 3]
    rows = []
    for order, deviation in allan["deviation_arcsec"].items():
        known = [(value, m) for value, m in zip(deviation, lengths, strict=True) if value]
        best, at = min(known)
        cells = " | ".join(decimal(deviation[place], 2) for place in columns)
        rows.append(
            f"| {order} | {allan['u_arcsec'][order]:.2f} | {cells} | {best:.2f}″ at {at} turns |"
        )
    return [
        "## How many turns to average",
        "",
        "The table shows the overlapping Allan deviation of the orders in the firmware's telemetry "
        "(calibration from every single turn), with cosine and sine combined",
        "(square root of the mean of the two variances), against the number m of averaged turns. "
        "Noise makes the deviation fall as 1/√m; a drift of D per turn makes it rise as D·m/√2.",
        "",
        "| Order | Stated u of a turn, ″ | "
        + " | ".join(f"m = {lengths[place]}" for place in columns)
        + " | Smallest |",
        "|---|---:|" + "---:|" * len(columns) + "---|",
        *rows,
        "",
        *_noise_as_stated(allan),
        "- If the deviation rises again at a larger m, the table changes noticeably during so many "
        "turns, and their average does not follow this change. This happens to order 1, because of "
        "heat and creep. The other orders "
        "do not drift, and their deviation continues to fall.",
        "- `keep` k = 0.8 averages about (1 + k)/(1 − k) = 9 turns.",
        "",
    ]


RIGHT = 0.1
"""Largest relative difference between the deviation of single turns and the stated u at which the
two count as equal."""


def _noise_as_stated(allan: Mapping[str, Any]) -> list[str]:
    off = _off(allan)
    if off > RIGHT:
        return [
            "- At m = 1 the Allan deviation differs from the uncertainty that the firmware states "
            f"for a turn by up to {percent(off)}. The run does not show whether the stated "
            "uncertainty is right: the table changes too fast, or the turns are too few."
        ]
    return [
        "- At m = 1 the Allan deviation equals the standard uncertainty that the firmware states "
        f"for a turn, within {percent(off)}: the stated uncertainty is right."
    ]


def _off(allan: Mapping[str, Any]) -> float:
    """Return the largest relative difference between the deviation of single turns and the stated
    u, over all orders."""
    ratios = [
        deviation[0] / allan["u_arcsec"][order]
        for order, deviation in allan["deviation_arcsec"].items()
    ]
    return float(np.max(np.abs(np.array(ratios) - 1.0)))


def _trends(found: Mapping[str, Any]) -> list[str]:
    first: dict[int, dict[str, Any]] = {}
    for one in found["trends"]:
        first.setdefault(one["order"], one)
    rows = [
        f"| {order} | {one['turn']} | {one['change_arcsec']:.1f} ± {2 * one['u_arcsec']:.1f} | "
        f"{one['turns']} | {sum(other['order'] == order for other in found['trends'])} |"
        for order, one in sorted(first.items())
    ]
    lines = found["turns"] // 16 - 7
    if lines < 1:
        return ["## Trends", "", "The run is too short for a line through 8 means of 16 turns.", ""]
    return [
        "## Trends",
        "",
        "`arctrue monitor PORT --trend ARCSEC` fits, for each order, straight lines through the "
        "latest 8 means of 16 turns of cosine and sine, and tests their slopes against the scatter",
        "about the lines (F test). Noise alone raises an alarm of any order in one of a thousand "
        "tests of all orders. This run raised these alarms:",
        "",
        "| Order | First alarm in turn | Change at this alarm, ″ (k = 2) | over turns | Number of "
        "alarms |",
        "|---|---:|---:|---:|---:|",
        *rows,
        "",
        f"The other orders up to {found['orders']} raised no alarm; each order was tested "
        f"{lines} times.",
        "",
    ]


def _fault(found: Mapping[str, Any]) -> list[str]:
    said = [(int(turn), text) for turn, texts in found["events"].items() for text in texts]
    if not said:
        return []
    (turn, text), *_ = said
    single = found["strategies"]["single"]
    lost = [number for number, alarms in single["alarms"].items() if "zero_lost" in alarms]
    refused = [
        f"the firmware refuses turn {number} ({reason.replace('_', ' ')})"
        for number, reason in single["refused"].items()
    ] or ["the capture of that turn restarts"]
    count = arcsec_per_count(found["counts_per_rev"])
    mean = single["mean_arcsec"]
    within = mean[turn - 1] / count
    after = (mean[min(turn + 2, len(mean) - 1)] - mean[max(turn - 3, 0)]) / count
    return [
        "## The fault",
        "",
        f"In turn {turn} {text}. With recalibration in every turn, {', '.join(refused)} and the "
        f"firmware raises the alarm `zero_lost` in turn {', '.join(lost)}. The mean output",
        f"angle is wrong by {decimal(within, 1)} counts in turn {turn} and by {decimal(after, 1)} "
        "counts three turns later: the next index pulse shows the lost counts, and the ramp adds "
        "them to the output (parameter `heal` = 1;",
        "[faults](faults.md)). No coefficient changes; the running average, the Allan deviation "
        "and the trends do not use the capture of that turn.",
        "",
    ]
