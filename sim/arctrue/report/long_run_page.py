"""Makes the page and the picture of ``arctrue long-run`` from its result."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from arctrue.base.percent import percent
from arctrue.base.units import arcsec_per_count
from arctrue.base.whole_file import whole_file
from arctrue.report.legend_below import legend_below
from arctrue.report.log_scale import set_log_x, set_log_y
from arctrue.report.numbers import decimal
from arctrue.report.svg import AFTER, BEFORE, INK, LIMIT, MUTED, house_style

PICTURE = "long_run.svg"
SAID = {
    "held": "first turn's coefficients, then held",
    "single": "calibrated anew in every turn",
    "average": "the same, running average (`keep` 0.8)",
    "model": "order 1 by the thermometer, the others averaged",
}
COLOURS = {"held": LIMIT, "single": BEFORE, "average": INK, "model": AFTER}
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
            f"This page simulates {found['turns']:,} turns, {hours:.1f} hours, of a table that "
            "warms and cools, whose disc creeps and whose head 1 once loses counts. It",
            "shows how the orders drift and which strategy of correction follows them. The command "
            "makes the page from [long-run.json](data/long-run.json).",
            "",
            "```sh",
            ".venv/bin/arctrue long-run sim/scenarios/long_run.toml --page docs/long-run.md "
            f"--json docs/data/long-run.json --out docs/images   # {found['cpu_s'] / 60:.0f} "
            "minutes of one core",
            ".venv/bin/arctrue long-run sim/scenarios/long_run.toml --turns 60     # a quick look",
            "```",
            "",
            "**Set-up.** The [virtual instrument](instrument.md) has "
            f"{found['lanes']} lanes and {found['counts_per_rev']:,} counts a turn ({count:.0f}″ "
            "each). Every edge passes through the compiled",
            "gateware, and in every turn the firmware's C captures, calibrates, loads and swaps "
            f"over the bus: {found['clocks'] / 1e6:,.0f} million clocks. No board was used.",
            "The course is [sim/scenarios/long_run.toml](../sim/scenarios/long_run.toml):",
            "",
            *(f"> {line}" for line in found["about"].splitlines()),
            "",
            "## Recalibration against model",
            "",
            "*Remaining*: RMS over the turn of the table's error (by its geometry, without noise) "
            "minus the correction that is active at the end of the turn,",
            "from turn 3 on. The uncorrected error is "
            f"{min(raw):.0f}″ to {max(raw):.0f}″, at {min(celsius):.1f} °C to "
            f"{max(celsius):.1f} °C.",
            "",
            f"| | Remaining, ″ | From turn {learned + 1} | Largest | Applied | Refused |",
            "|---|---:|---:|---:|---:|---:|",
            *(
                f"| {SAID[name]} | {one['rms_arcsec']:.2f} | "
                f"{one['rms_after_learning_arcsec']:.2f} | {one['largest_arcsec']:.2f} | "
                f"{one['applied']} | {len(one['refused'])} |"
                for name, one in found["strategies"].items()
            ),
            "",
            f"![Temperature, error left, Allan deviation](images/{PICTURE})",
            "",
            *_model(found),
            "- A single turn is noisy: with counts of "
            f"{count:.0f}″ and {found['samples']} samples order 1 has a standard uncertainty of "
            f"{found['allan']['u_arcsec']['1']:.1f}″ (at 2²⁴ counts",
            "  and 12,000 samples some thousandths). The average has less noise and lags by some "
            "turns.",
            "- The firmware keeps the active coefficients if a turn's candidate is not expected to "
            "be better; therefore not every turn is applied.",
            f"- The edges of the output deviate by {_median_output(found):.0f}″ RMS with each "
            "strategy: an edge leaves with an edge of head 1, and a count",
            f"  over √12 is {rounding:.0f}″.",
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
        f"- The model is fitted to the telemetry of turns 1 to {found['learned_turns']}, by "
        f"least squares over 1, temperature and turn ({orders}).",
        "  It is loaded as lanes that [follow the temperature]"
        "(firmware-load.md#lanes-that-follow-the-temperature), measured by a thermometer on the "
        "table in steps of 1/128 K. For warmer turns than",
        "  those of the fit it extrapolates.",
        "- The model has no noise and no lag, but follows only what it contains: in turns "
        f"3 to {found['learned_turns']} it leaves {_part(found, 'model', first=True):.2f}″, the "
        f"running average {_part(found, 'average', first=True):.2f}″; in the last",
        "  hundred turns, after the disc has crept further, "
        f"{_part(found, 'model', first=False):.2f}″ and "
        f"{_part(found, 'average', first=False):.2f}″. Recalibration needs no knowledge and "
        "follows every change as fast as its noise allows.",
        "  The firmware combines both: the orders of the file follow the model, all others the "
        "calibration. Refit the model if the table changes in a way that it does not contain.",
        *_worst(found),
    ]


def _part(found: Mapping[str, Any], name: str, *, first: bool) -> float:
    """Return the RMS error of the turns used for learning (``first``), or of the last hundred
    turns."""
    left = np.asarray(found["strategies"][name]["left_arcsec"], dtype=np.float64)
    part = left[2 : found["learned_turns"]] if first else left[-100:]
    return float(np.sqrt(np.mean(part**2)))


def _worst(found: Mapping[str, Any]) -> list[str]:
    """Return the orders that are active in the worst turn with calibration from single turns."""
    one = found["strategies"]["single"]
    orders = ", ".join(
        f"{order} ({amplitude:.0f}″)" for order, amplitude in one["largest_orders"].items()
    )
    said = [
        f"- In the worst turn of the single calibrations, {one['largest_turn']}, these orders are "
        f"active: {orders}."
    ]
    if WEAK_ORDER in one["largest_orders"]:
        said += [
            "  An order that noise lifts above its limit is applied; this happens to one of all "
            f"orders in 5 % of turns. Order {WEAK_ORDER} has a noise gain of 19 at 33°, so that",
            "  it then does harm. Averaging makes this rare; `set orders 10` or another "
            "[angle between the heads](head-angle.md) prevents it.",
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
        "Overlapping Allan deviation of the orders in the firmware's telemetry, calibrated from "
        "single turns; cosine and sine together (root mean of",
        "the two variances). Noise falls as 1/√m with the number m of averaged turns; a drift of D "
        "per turn rises as D·m/√2.",
        "",
        "| Order | u of a turn, ″ | "
        + " | ".join(f"m = {lengths[place]}" for place in columns)
        + " | Least |",
        "|---|---:|" + "---:|" * len(columns) + "---|",
        *rows,
        "",
        *_noise_as_stated(allan),
        "- Where a curve rises again, a longer average would not follow the table: heat and creep "
        "in order 1. The other orders do not drift and continue to fall.",
        "- `keep` 0.8 averages about 9 turns (1 + k over 1 − k).",
        "",
    ]


RIGHT = 0.1
"""Largest relative difference between the deviation of single turns and the stated u at which the
two count as equal."""


def _noise_as_stated(allan: Mapping[str, Any]) -> list[str]:
    off = _off(allan)
    if off > RIGHT:
        return [
            f"- At m = 1 it differs from the uncertainty that the firmware states for a turn by up "
            f"to {percent(off)}: the table changes too fast, or the turns are too few, to decide."
        ]
    return [
        "- At m = 1 it equals the standard uncertainty that the firmware states for a turn, within "
        f"{percent(off)}: the stated noise is right."
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
        return ["## Trends", "", "Too few turns for a line of 8 means of 16 turns.", ""]
    return [
        "## Trends",
        "",
        "`arctrue monitor PORT --trend ARCSEC` fits, for each order, a straight line through the "
        "latest 8 means of 16 turns, and tests its slope against the scatter about",
        "the line (F test); noise alone raises an alarm in one of a thousand lines. In this run:",
        "",
        "| Order | First alarm in turn | Change, ″ (k = 2) | within turns | Alarms |",
        "|---|---:|---:|---:|---:|",
        *rows,
        "",
        f"The other orders of {found['orders']}: no alarm in {lines} lines.",
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
        f"turn {number} is refused ({reason.replace('_', ' ')})"
        for number, reason in single["refused"].items()
    ] or ["the turn's capture restarts"]
    count = arcsec_per_count(found["counts_per_rev"])
    mean = single["mean_arcsec"]
    within = mean[turn - 1] / count
    after = (mean[min(turn + 2, len(mean) - 1)] - mean[max(turn - 3, 0)]) / count
    return [
        "## The fault",
        "",
        f"Turn {turn}: {text}. With recalibration in every turn: {', '.join(refused)}; alarm "
        f"`zero_lost` in turn {', '.join(lost)}. The mean of the output",
        f"is wrong by {decimal(within, 1)} counts over that turn and by {decimal(after, 1)} three "
        "turns later: the next index shows the lost counts, and `heal` puts them back",
        "([faults](faults.md)). No coefficient changes, and averages, Allan deviation and trends "
        "do not use the capture of that turn.",
        "",
    ]


def plot_long_run(found: Mapping[str, Any], folder: Path) -> Path:
    """Draw temperature and error over the turns, and the Allan deviation of the orders."""
    path = folder / PICTURE
    turns = np.arange(1, found["turns"] + 1)
    with house_style():
        figure = Figure(figsize=(9.6, 9.0), layout="constrained")
        warmth, left, allan = figure.subplots(3, 1, height_ratios=[1, 2.2, 2.4])
        left.sharex(warmth)
        warmth.plot(turns, found["temperature_c"], color=MUTED)
        warmth.set_ylabel("°C")
        warmth.set_title("Temperature of the table")
        for name, one in found["strategies"].items():
            left.plot(
                turns[2:],
                one["left_arcsec"][2:],
                color=COLOURS[name],
                linewidth=0.9,
                label=SAID[name].replace("`", ""),
            )
        set_log_y(left)
        left.axvline(found["learned_turns"], color=MUTED, linestyle=":", linewidth=1)
        left.set_title("Error that the coefficients leave (dotted: the model is learned up to it)")
        left.set_ylabel("RMS, ″")
        left.set_xlabel("turn")
        legend_below(left, columns=2)
        _plot_allan(allan, found)
        folder.mkdir(parents=True, exist_ok=True)
        with whole_file(path) as unfinished:
            figure.savefig(unfinished, format="svg", metadata={"Date": None})
    return path


def _plot_allan(axes: Axes, found: Mapping[str, Any]) -> None:
    lengths = np.asarray(found["allan"]["averaged_turns"], dtype=np.float64)
    colours = (BEFORE, AFTER, INK)
    for colour, (order, deviation) in zip(
        colours, found["allan"]["deviation_arcsec"].items(), strict=False
    ):
        values = np.array([np.nan if value is None else value for value in deviation])
        axes.plot(lengths, values, "o-", color=colour, markersize=3, label=f"order {order}")
        u = found["allan"]["u_arcsec"][order]
        axes.plot(lengths, u / np.sqrt(lengths), "--", color=colour, linewidth=0.8)
    set_log_x(axes)
    set_log_y(axes)
    axes.set_title("Allan deviation of single turns' orders; broken: the stated u over √m")
    axes.set_xlabel("turns averaged, m")
    axes.set_ylabel("deviation, ″")
    axes.legend(fontsize=8)
