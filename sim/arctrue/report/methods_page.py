"""Makes the page of ``arctrue methods`` from its result."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from arctrue.report.charts.methods_picture import PICTURE

NOT_BUILT = (
    ("Ring laser gyroscope [2]",
     "The gyroscope is another reference instrument, not a calibration from the heads' readings."),
    ("EDA with fewer heads at chosen places [6]",
     "The method is not simulated as cited; the rows *Mean of 4 heads* show the effect of unevenly "
     "spaced heads."),
    ("VEDA [7]",
     "The correction that the paper describes agrees within 10⁻¹³ with the correction by the "
     "transfer function in the row *α nominal*."),
    ("Filtering the moiré signals [10], correcting the signals' offset, gain and phase [12]",
     "Both act on the sine and cosine of a head before the counter; the simulation contains no "
     "error within a line (effect `subdivision_error`)."),
    ("RBF neural network [11]",
     "The network draws a smooth curve through the errors measured with a reference; between the "
     "faces it has no more information than the row *Harmonics from a reference*."),
    ("Radial code tracks next to the scale [13]", "The method requires another disc."),
    ("Three calibration heads and one measuring head [14]",
     "The row *4 heads, least squares* does the same: it calibrates head 1 with four heads."),
    ("Polynomial fit [16]",
     "The polynomial describes a linear encoder over temperature; the error of a rotary table is "
     "periodic in the angle."),
)  # fmt: skip
"""Methods from the paper's introduction that have no row in the table, each with the reason."""


def methods_page(found: Mapping[str, Any]) -> str:
    """Return the page as Markdown."""
    given = found["settings"]
    motion_um = given["radial_motion_m"] * 1e6
    raw = found["uncorrected"]
    rows = [
        f"| {one['title']} | {one['heads']} | {one['output']} | {_span(one['span_arcsec'])} | "
        f"{one['rms_arcsec']:.3f} | {one['rms_without_motion_arcsec']:.3f} | "
        f"{one['rms_later_arcsec']:.3f} | {_largest(one)} |"
        for one in found["methods"]
    ]
    needs = [
        f"| {one['title']} | {one['needs']} | {one['cannot_see']} | {one['source']} |"
        for one in found["methods"]
    ]
    heads = [
        f"| {one['title']} | {', '.join(f'{p:g}°' for p in one['places_deg'])} | "
        f"{_gain(one['gain'][0])} | {_gain(one['gain_weak_order'])} | "
        f"{_gain(one['worst_gain_to_40'])} | {_gain(one['worst_gain_to_64'])} | "
        f"{_gain(one['worst_gain_to_128'])} | {_gain(one['gain_blind_order'])} | "
        f"{'–' if one['mean_noise'] is None else format(one['mean_noise'], '.2f')} |"
        for one in found["places"]
    ]
    return "\n".join(
        [
            "# Methods on the same table",
            "",
            "`arctrue methods` calibrates one simulated table with methods of the paper's "
            "introduction ([except these](#left-out)) and with two to four heads. The command "
            "compares each",
            "corrected angle with the true angle, which the methods do not use, and makes this "
            "page from [methods.json](data/methods.json).",
            "",
            "```sh",
            ".venv/bin/arctrue methods --page docs/methods.md --json docs/data/methods.json "
            "--out docs/images",
            "```",
            "",
            "| Condition, equal for all methods | |",
            "|---|---|",
            f"| measuring time | {given['minutes']:g} minutes: {given['turns']} turns at "
            f"{given['speed_deg_s']:g}°/s, or {given['cycles']} cycles of 24 faces with "
            f"{given['station_s']:g} s per face |",
            f"| noise, standard deviation | {given['noise_arcsec']:g}″ of a head's reading, "
            f"{given['scatter_arcsec']:g}″ of an autocollimator reading |",
            "| mounting of the heads | angle within ± 50″, radius within "
            f"± {given['radius_tolerance_m'] * 1e3:g} mm; each head detects the index mark within "
            f"± {given['index_detection_arcsec']:g}″ of its true place and repeats within "
            "± 1 count |",
            "| motion of the table | speed ripple of "
            f"{given['ripple_rad'] * given['ripple_order'] * 100:.1f} %; friction as in "
            "[stop and go](stop-and-go.md) |",
            "| reference | the instruments of the paper's Table 3 |",
            "| disc | the disc of [`arctrue revolution`](instrument.md) with added orders 11 "
            "(0.4″), 12 (0.2″), 24 (0.3″) and 120 (0.2″), each difficult for some method, and 47 "
            "(0.05″) and 77 (0.03″), which no method fits |",
            f"| axis motion | {motion_um:g} µm at order 2 along a line; {0.5 * motion_um:g} µm at "
            f"order 3 on a circle; {0.3 * motion_um:g} µm at order 1 and {0.2 * motion_um:g} µm at "
            f"order 13 on backward circles; {0.3 * motion_um:g} µm at order 9 on a forward circle "
            "|",
            f"| orders | 1 to {given['most_order']} and 120, if the method can fit them; the "
            "correction omits orders with a noise gain above 50 |",
            "",
            "*Later*: the calibration, unchanged, is evaluated again three turns later, when the "
            "disc's centre has shifted by 2 µm (heat) and the bearing's balls move the axis by "
            "0.25 µm (0.95″).",
            f"The uncorrected error is {_span(raw['span_arcsec'])}″, {raw['rms_arcsec']:.2f}″ RMS.",
            "",
            "| Method | Heads | Output | Remaining error, ″ | RMS, ″ | RMS, axis at rest, ″ "
            "| RMS, *later*, ″ | Largest remaining orders, ″ |",
            "|---|---:|---|---:|---:|---:|---:|---|",
            *rows,
            "",
            "| Method | Needs | Does not correct, or attributes wrongly | Source |",
            "|---|---|---|---|",
            *needs,
            "",
            "Numbers in brackets are the paper's references. The tables show one random draw of "
            "noise and mounting; `--seed` selects another draw.",
            "",
            "## Left out",
            "",
            "The comparison omits these methods of the paper's introduction:",
            "",
            "| Method | Reason |",
            "|---|---|",
            *(f"| {name} | {why} |" for name, why in NOT_BUILT),
            "",
            f"![Remaining error at every order](images/{PICTURE})",
            "",
            "## How many heads",
            "",
            "The gain of an order is the noise of its estimated coefficient, divided by the noise "
            "of one head's reading; ∞: the heads do not determine the order. Places are angles "
            "from head 1.",
            "*Mean* is the noise of the weighted mean that does not contain axis translation, "
            "divided by the noise of one reading; –: no such mean exists.",
            "",
            "| Heads | Places | Order 1 | Order 11 | Worst of orders 1 to 40 | 1 to 64 | 1 to 128 "
            "| Order 120 | Mean |",
            "|---|---|---:|---:|---:|---:|---:|---:|---:|",
            *heads,
            "",
            *_verdict(found),
            "",
        ]
    )


def _verdict(found: Mapping[str, Any]) -> list[str]:
    """Return sentences about the benefit of a third and a fourth head, and of the mean."""
    by_name = {one["name"]: one for one in found["methods"]}
    two, three, four = (by_name[f"{n}_heads_least_squares"] for n in ("two", "three", "four"))
    pair, third = found["places"][:2]
    listed, every, spare = found["places"][3:6]
    plain, mean3 = by_name["mean_of_two"], by_name["mean_of_three_calibrated"]
    mean4 = by_name["mean_of_four_calibrated"]
    own = ", ".join(
        f"{min(one['u_arcsec']):.0f} to {max(one['u_arcsec']):.0f}″ if {one['motion']}"
        for one in found["own_places"]
    )
    return [
        f"- **A third head** at {third['places_deg'][2]:g}° determines the orders that two heads "
        "do not: the worst gain of orders 1 to 40 falls from "
        f"{_gain(pair['worst_gain_to_40'])} to {_gain(third['worst_gain_to_40'])}, and the gain "
        f"of order 120 becomes {_gain(third['gain_blind_order'])}.",
        "  With the axis at rest, the remaining error of head 1 is "
        f"{three['rms_without_motion_arcsec']:.3f}″ RMS (two heads: "
        f"{two['rms_without_motion_arcsec']:.3f}″). At an order with axis motion, three heads "
        "cannot",
        "  separate axis and disc: three motions (the table's rotation, the axis' forward and "
        "backward circle) already explain all three readings. With axis motion, "
        f"{three['rms_arcsec']:.3f}″ remain.",
        "  Three heads have a weighted mean that does not contain axis translation: its error is "
        f"{mean3['rms_arcsec']:.3f}″, and *later* {mean3['rms_later_arcsec']:.3f}″. This error is "
        "motion that the calibration attributed to the disc.",
        "- **A fourth head** separates disc and axis. If the axis is known to move at orders 1 to "
        "8 only, the worst gain of orders 1 to 128 is "
        f"{_gain(listed['worst_gain_to_128'])}. With unknown motion at every order, the",
        f"  worst gain of orders 1 to 64 is {_gain(every['worst_gain_to_64'])} at these places and "
        f"{_gain(spare['worst_gain_to_64'])} at the places in the last row. Head 1, corrected "
        f"under the assumption of motion at orders 1 to 8 only, keeps {four['rms_arcsec']:.3f}″,",
        f"  mostly from motion at other orders, and {four['rms_later_arcsec']:.3f}″ *later*, "
        "mainly because the disc's centre has shifted.",
        "- **Order 1 of the axis**: a forward circle of the axis gives the same readings as an "
        "eccentric disc, with any number of heads. Four heads separate a backward circle or a "
        "line from the disc.",
        f"- **The calibrated mean of four heads** keeps {mean4['rms_arcsec']:.3f}″ RMS, and "
        f"{mean4['rms_later_arcsec']:.3f}″ *later* (largest remaining orders: "
        f"{_largest(mean4)}). The disc error that is subtracted from the mean is",
        "  estimated from the one combination of the four readings that contains neither table nor "
        "axis motion. An uncalibrated mean keeps the part of the disc error that is equal at all "
        f"heads ({plain['rms_arcsec']:.2f}″ for two heads at 180°).",
        "- **Places of the heads**: the data determine the places only if the axis is known to be "
        "at rest at some orders of the disc. One turn with the axis at rest gives their standard "
        "uncertainty:",
        f"  {own}.",
        "  If motion is unknown at every order, the calibration refuses to estimate places; the "
        "mean tolerates places that are wrong by 10″.",
        "- **Radii of the heads**: unequal radii cause an order 1 in the mean. An unknown backward "
        "circle of the axis at order 1 limits the accuracy of estimated radii.",
    ]


def _span(values: list[float]) -> str:
    return f"[{values[0]:.3f}, {values[1]:.3f}]"


def _gain(value: float | None) -> str:
    return "∞" if value is None else f"{value:.2g}" if value < 10 else f"{value:.0f}"


def _largest(one: Mapping[str, Any]) -> str:
    amplitude = np.asarray(one["amplitude_arcsec"])
    worst = np.argsort(-amplitude)[:3]
    return ", ".join(f"{order + 1}: {amplitude[order]:.3f}" for order in worst)
