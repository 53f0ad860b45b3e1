"""Makes the page and the picture of ``arctrue methods`` from its result."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from arctrue.report.legend_below import legend_below
from arctrue.report.log_scale import set_log_y
from arctrue.report.picture_file import save_picture
from arctrue.report.svg import AFTER, BEFORE, LIMIT, house_style

PICTURE = "methods.svg"
SMALLEST_ARCSEC = 1e-4
"""Lower end of the picture's scale, arcseconds."""
NOT_BUILT = (
    ("Ring laser gyroscope [2]", "another reference instrument, not a calibration from readings"),
    ("EDA with fewer heads at chosen places [6]",
     "not as cited; the means of four heads at uneven places show what such places do"),
    ("VEDA [7]",
     "as the paper describes it, its correction is that of the transfer function with the nominal "
     "α to 10⁻¹³: the row *α nominal*"),
    ("Filtering the moiré signals [10], correcting the signals' offset, gain and phase [12]",
     "act on the sine and cosine of a head before the counter; the simulation has no error within "
     "a line (effect `subdivision_error`)"),
    ("RBF neural network [11]",
     "a smooth curve through the errors that a reference shows: between the faces it contains no "
     "more than the harmonics from a reference"),
    ("Radial code tracks next to the scale [13]", "another disc"),
    ("Three calibration heads and one that measures [14]",
     "the rows of four heads by least squares, whose output is head 1"),
    ("Polynomial fit [16]", "of linear encoders over temperature; a turn is periodic"),
)  # fmt: skip
"""Methods from the paper's introduction that have no row in the table, each with the reason."""


def methods_page(found: Mapping[str, Any]) -> str:
    """Return the page as Markdown."""
    given = found["settings"]
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
            "`arctrue methods` calibrates one simulated table with the methods of the paper's "
            "introduction and with several heads, and compares the",
            "result with the true angle, which no method sees. The command makes this page from "
            "[methods.json](data/methods.json).",
            "",
            "```sh",
            ".venv/bin/arctrue methods --page docs/methods.md --json docs/data/methods.json "
            "--out docs/images",
            "```",
            "",
            "| Condition of all methods | |",
            "|---|---|",
            f"| duration | {given['minutes']:g} minutes: {given['turns']} turns at "
            f"{given['speed_deg_s']:g}°/s, or {given['cycles']} cycles of 24 faces, "
            f"{given['station_s']:g} s each |",
            f"| noise | {given['noise_arcsec']:g}″ on a reading of a head, "
            f"{given['scatter_arcsec']:g}″ on a reading of the autocollimator |",
            f"| heads | mounted to ± 50″ and ± {given['radius_tolerance_m'] * 1e3:g} mm of "
            f"radius; index marks detected ± {given['index_detection_arcsec']:g}″ off, "
            "repeating to ± 1 count |",
            "| motion | speed ripple of "
            f"{given['ripple_rad'] * given['ripple_order'] * 100:.1f} %; friction of "
            "[stop and go](stop-and-go.md) |",
            "| reference | the instruments of the paper's Table 3 |",
            "| disc | that of [`arctrue revolution`](instrument.md); also orders 11 (0.4″), 12 "
            "(0.2″), 24 (0.3″) and 120 (0.2″), each difficult for some method, and 47 (0.05″) and "
            "77 (0.03″), which no method fits |",
            f"| axis motion | {given['radial_motion_m'] * 1e6:g} µm at order 2 on a line; half as "
            "much at order 3 on a circle; 0.2 to 0.3 as much backwards at orders 1 and 13 and "
            "forwards at 9 |",
            f"| orders | 1 to {given['most_order']} and 120 if the method can fit them, applied "
            "up to a noise gain of 50 |",
            "",
            "*Later*: the same calibration after heat moved the disc's centre by 2 µm and the "
            "balls of the bearing moved the axis by 0.25 µm (0.95″), some turns later.",
            f"Uncorrected: {_span(raw['span_arcsec'])}″, {raw['rms_arcsec']:.2f}″ RMS.",
            "",
            "| Method | Heads | Output | Error, ″ | RMS, ″ | RMS, axis at rest, ″ | RMS, later, ″ "
            "| Largest remaining orders, ″ |",
            "|---|---:|---|---:|---:|---:|---:|---|",
            *rows,
            "",
            "| Method | Needs | Cannot see | Source |",
            "|---|---|---|---|",
            *needs,
            "",
            "Numbers in brackets are the paper's references. The table shows one draw of noise and "
            "mounting; `--seed` makes another.",
            "",
            "These methods of the paper's introduction have no row:",
            "",
            "| | |",
            "|---|---|",
            *(f"| {name} | {why} |" for name, why in NOT_BUILT),
            "",
            f"![Remaining error at every order](images/{PICTURE})",
            "",
            "## How many heads",
            "",
            "Gain: noise of an order over the noise of one head's reading; ∞: not seen. Places in "
            "degrees after head 1. *Mean*: noise of the weighted mean",
            "that sees no translation of the axis, over that of one reading; –: there is none.",
            "",
            "| | Places | Order 1 | Order 11 | Worst to 40 | to 64 | to 128 | Order 120 | Mean |",
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
    listed, every = found["places"][3:5]
    plain, mean3 = by_name["mean_of_two"], by_name["mean_of_three_calibrated"]
    mean4 = by_name["mean_of_four_calibrated"]
    own = "; ".join(
        f"{one['motion']} {min(one['u_arcsec']):.0f} to {max(one['u_arcsec']):.0f}″"
        for one in found["own_places"]
    )
    return [
        f"- **A third head** at {third['places_deg'][2]:g}° removes the blind orders: the worst "
        f"gain to order 40 falls from {_gain(pair['worst_gain_to_40'])} to "
        f"{_gain(third['worst_gain_to_40'])}, and order 120 is seen.",
        f"  With the axis at rest {three['rms_without_motion_arcsec']:.3f}″ RMS remain (two heads: "
        f"{two['rms_without_motion_arcsec']:.3f}″). At an order at which the axis moves, three "
        "heads cannot separate",
        "  axis and disc, because table motion and two circles of the axis use all three readings "
        f"({three['rms_arcsec']:.3f}″ with the moving bearing). Three heads have a",
        "  weighted mean without any axis motion "
        f"({mean3['rms_later_arcsec']:.3f}″ before and after the disc's centre moves); its "
        "remaining error is motion that the calibration attributed to the disc.",
        "- **A fourth head** separates disc and axis. If the axis is known to move at orders 1 to "
        f"8 only, the worst gain to 128 is {_gain(listed['worst_gain_to_128'])}; with unknown "
        "motion at every order it is",
        f"  {_gain(every['worst_gain_to_128'])} at these places, and lower at others. Head 1, "
        f"corrected with the list, keeps {four['rms_arcsec']:.3f}″ from the orders outside the "
        f"list, and {four['rms_later_arcsec']:.3f}″ after the axis moved differently.",
        "- **Order 1 of the axis**: for any number of heads its forward circle equals an eccentric "
        "disc. Four heads see a backward circle or a line.",
        f"- **The calibrated mean of four heads** keeps {mean4['rms_arcsec']:.3f}″, and "
        f"{mean4['rms_later_arcsec']:.3f}″ later, mostly from orders of the disc that were not "
        "fitted. Its disc error comes from the",
        "  one combination of four readings that contains neither table nor axis motion. "
        "Uncalibrated means keep the part of the disc error that the heads have in common "
        f"({plain['rms_arcsec']:.2f}″ with two at 180°).",
        "- The data determine the heads' places only if the axis is known to be at rest at some "
        "orders of the disc. Standard uncertainties from one turn, axis",
        f"  at rest: {own}. With unknown motion at every order the calibration refuses to "
        "estimate places; the mean",
        "  tolerates 10″. Unequal radii leave order 1 in the mean. The calibration estimates them "
        "as well as the axis is known to make no backward circle once a turn.",
    ]


def plot_methods(found: Mapping[str, Any], folder: Path) -> Path:
    """Draw the residual of every method by order, and the noise gain of two, three and four
    heads."""
    path = folder / PICTURE
    with house_style():
        figure = Figure(figsize=(9.6, 9.6), layout="constrained")
        table, gains = figure.subplots(2, 1, height_ratios=[3, 2])
        entries = found["methods"]
        amplitude = np.array([one["amplitude_arcsec"] for one in entries])
        image = table.imshow(
            np.log10(np.maximum(amplitude[:, :40], SMALLEST_ARCSEC)),
            aspect="auto",
            cmap="magma_r",
            extent=(0.5, 40.5, len(entries) - 0.5, -0.5),
            vmin=np.log10(SMALLEST_ARCSEC),
            vmax=0.0,
            interpolation="nearest",
        )
        table.set_yticks(range(len(entries)), [one["title"] for one in entries], fontsize=8)
        table.set_xlabel("order")
        table.grid(visible=False)
        table.set_title("What each method leaves, amplitude by order")
        bar = figure.colorbar(image, ax=table, pad=0.01, ticks=[-4, -3, -2, -1, 0])
        bar.ax.set_yticklabels(["10⁻⁴″", "10⁻³″", "0.01″", "0.1″", "1″"])
        colours = (BEFORE, LIMIT, "#3a7d44", "#8a6fb0", AFTER, "#888888")
        for one, colour in zip(found["places"], colours, strict=True):
            gain = [np.nan if value is None else value for value in one["gain"]]
            places = ", ".join(f"{p:g}°" for p in one["places_deg"])
            gains.plot(
                range(1, len(gain) + 1), gain, color=colour, linewidth=1.2,
                label=f"{one['title']}: {places}",
            )  # fmt: skip
        set_log_y(gains)
        gains.set_xlabel("order")
        gains.set_ylabel("noise over that of a head")
        gains.set_title("Noise gain of two, three and four heads (gap: not seen)")
        legend_below(gains, columns=2)
        return save_picture(figure, path)


def _span(values: list[float]) -> str:
    return f"[{values[0]:.3f}, {values[1]:.3f}]"


def _gain(value: float | None) -> str:
    return "∞" if value is None else f"{value:.2g}" if value < 10 else f"{value:.0f}"


def _largest(one: Mapping[str, Any]) -> str:
    amplitude = np.asarray(one["amplitude_arcsec"])
    worst = np.argsort(-amplitude)[:3]
    return ", ".join(f"{order + 1}: {amplitude[order]:.3f}" for order in worst)
