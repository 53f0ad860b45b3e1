"""Makes the page and the picture of ``arctrue error-sources`` from its result."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from arctrue.base.percent import percent
from arctrue.report.legend_below import legend_below
from arctrue.report.log_scale import set_log_x
from arctrue.report.picture_file import save_picture
from arctrue.report.svg import AFTER, BEFORE, LIMIT, MUTED, house_style

PICTURE = "calibration_budget.svg"
TITLES = {"least_squares": "least squares (`arctrue calibrate`)", "paper": "the paper's method"}


def error_budget_page(found: Mapping[str, Any]) -> str:
    """Return the page as Markdown."""
    return "\n".join(
        [
            "# Budget of the calibration",
            "",
            "This page shows what limits the corrected angle: it simulates every source of error "
            "alone, then all together, and compares the uncertainty",
            "that the calibration states with drawn calibrations. It ends with the budget of the "
            "paper's experiment in the form of EURAMET cg-23.",
            "The command makes this page from [calibration-budget.json]"
            "(data/calibration-budget.json).",
            "",
            "```sh",
            ".venv/bin/arctrue error-sources --page docs/calibration-budget.md "
            "--json docs/data/calibration-budget.json --out docs/images",
            *_command_of_drawn(found),
            ".venv/bin/arctrue budget SET          # for your own set; --json has U at every angle",
            "```",
            "",
            *_sources(found),
            *_angles(found),
            *_drawn(found),
            *_experiment(found["experiment"]),
        ]
    )


def _sources(found: Mapping[str, Any]) -> list[str]:
    own, paper = (found["methods"][name] for name in TITLES)
    rows = [
        f"| {ours['title']} | {ours['size']} | {_with_u(ours)} | {_with_u(theirs)} |"
        for ours, theirs in zip(own["sources"], paper["sources"], strict=True)
    ]
    noise = own["sources"][1]
    share = (noise["of_weak_order_arcsec"] / noise["rms_arcsec"]) ** 2
    rows.insert(
        2,
        f"| … through order 11 alone | noise gain 19 | {_value(noise['of_weak_order_arcsec'])} | "
        f"{_value(paper['sources'][1]['of_weak_order_arcsec'])} |",
    )
    largest = max(own["sources"], key=lambda one: one["rms_arcsec"])
    return [
        "## By source",
        "",
        "RMS over the turn of the remaining error of head 1, ″; for a random source the root mean "
        f"square of {found['draws']} draws ± its standard error. The table is that of",
        "[`arctrue revolution`](instrument.md) with 0.4″ of order 11; one turn of 12,000 samples, "
        "orders 1 to 16, 2²⁴ counts. Without any source",
        f"{own['exact_rms_arcsec']:.0e}″ and {paper['exact_rms_arcsec']:.0e}″ remain.",
        "",
        f"| Source | Size | {TITLES['least_squares']} | {TITLES['paper']} |",
        "|---|---|---:|---:|",
        *rows,
        f"| **root of the sum of squares** | | {_value(own['sum_arcsec'])} | "
        f"{_value(paper['sum_arcsec'])} |",
        f"| **all simulated together** | | {_with_u(own['whole'])} | {_with_u(paper['whole'])} |",
        "",
        f"- The largest source is {largest['title']}: no calibration of orders removes it, because "
        "it repeats with the lines of the disc. Its size is an",
        "  assumption; [`subdivision_error`](effects.md#subdivision_error) estimates the real one.",
        *_sum_and_whole(found),
        f"- The transfer function predicts the noise without a draw: 0.1″ · √(4 Σ |TF(n)|² / "
        f"12,000) = {noise['expected_arcsec']:.4f}″.",
        f"- {percent(share)} of the noise comes through order 11 alone, because of α = 33°: "
        "[the angle between the heads](head-angle.md).",
        "- The paper's method adds the errors of uneven sampling and of the approximation in (8); "
        "least squares at the readings has neither.",
        "- α: the noise of the index is negligible; the place where the heads *detect* the mark "
        "determines the error. `table.index_detection_arcsec` states it.",
        f"- Without recalibration the table's error changes by "
        f"{found['heat_not_recalibrated_arcsec_per_k']:.1f}″ per kelvin: 2 K give "
        f"{2 * found['heat_not_recalibrated_arcsec_per_k']:.0f}″, "
        f"{2 * found['heat_not_recalibrated_arcsec_per_k'] / own['whole']['rms_arcsec']:.0f} times "
        "all sources above.",
        f"- The ramp changes by {found['ramp_rate_arcsec_s']:.0f}″ a second: a first swap of 150″ "
        f"takes {150 / found['ramp_rate_arcsec_s']:.1f} s, a later one a millisecond.",
        "",
    ]


def _sum_and_whole(found: Mapping[str, Any]) -> list[str]:
    """Return sentences that compare the sum of the sources with the result of all sources
    together."""
    shares, errors = [], []
    for name in TITLES:
        one = found["methods"][name]
        whole = one["whole"]
        shares.append(one["sum_arcsec"] / whole["rms_arcsec"] - 1.0)
        u_sum = np.linalg.norm([row["rms_arcsec"] * row["u_rms_arcsec"] for row in one["sources"]])
        u_both = np.hypot(u_sum / one["sum_arcsec"], whole["u_rms_arcsec"])
        errors.append((one["sum_arcsec"] - whole["rms_arcsec"]) / u_both)
    return [
        f"- Sum and whole differ by {100 * shares[0]:+.1f} % and {100 * shares[1]:+.1f} %, "
        f"{abs(errors[0]):.1f} and {abs(errors[1]):.1f} standard errors of the difference: the "
        "sources are nearly independent.",
    ]


def _effective(found: Mapping[str, Any]) -> float:
    """Return the effective degrees of freedom (GUM, G.2b) from the rows with finite degrees of
    freedom."""
    fourth = sum(
        one["u_arcsec"] ** 4 / one["degrees_of_freedom"]
        for one in found["rows"]
        if one["degrees_of_freedom"]
    )
    return float(found["u_arcsec"] ** 4 / fourth)


def _angles(found: Mapping[str, Any]) -> list[str]:
    by_angle = found["methods"]["least_squares"]["by_angle"]
    covariance, drawn = (np.array(by_angle[f"{name}_arcsec"]) for name in ("covariance", "drawn"))
    return [
        "## At every angle",
        "",
        "The covariance of a calibration gives a *partial* uncertainty of ε, from noise, "
        "quantisation and α; the index term changes all orders together.",
        f"Twice this uncertainty is {covariance.min():.3f}″ to {covariance.max():.3f}″ "
        "(`Estimate.u_error_arcsec`; tests compare it with drawn calibrations). Twice the RMS of "
        "the remaining error with all sources is",
        f"{drawn.min():.2f}″ to {drawn.max():.2f}″. Only the second is an expanded uncertainty U "
        "(k = 2) of the corrected angle, for the sizes above.",
        "",
        f"![Every source, and the uncertainty over the angle](images/{PICTURE})",
        "",
    ]


def _command_of_drawn(found: Mapping[str, Any]) -> list[str]:
    if "monte_carlo" not in found:
        return []
    plan = found["monte_carlo"]["plan"]
    return [
        f".venv/bin/arctrue monte-carlo build/mc --trials {plan['trials']} --runs {plan['runs']} "
        f"--samples {plan['samples']}",
        ".venv/bin/arctrue error-sources --from docs/data/calibration-budget.json "
        "--monte-carlo build/mc --page docs/calibration-budget.md "
        "--json docs/data/calibration-budget.json",
    ]


def _drawn(found: Mapping[str, Any]) -> list[str]:
    """Return sentences that compare the uncertainty from the covariance with the calibrations drawn
    by ``arctrue monte-carlo``."""
    if "monte_carlo" not in found:
        return []
    plan, cases = found["monte_carlo"]["plan"], found["monte_carlo"]["cases"]
    trials = max(one["trials"] for one in cases)
    rows = [
        f"| {one['title']} | {one['stated_arcsec']:.4f} | {one['deviation_arcsec']:.4f} | "
        f"{one['deviation_arcsec'] / one['stated_arcsec']:.2f} | {100 * one['coverage']:.1f} | "
        f"{one['stated_uncertainty']} |"
        for one in cases
    ]
    return [
        "## The covariance against drawn calibrations",
        "",
        "*Stated u*: RMS over the turn of the standard uncertainty of ε that the calibration "
        "states, ″. *Drawn*: RMS of the deviations of drawn calibrations, ″.",
        f"[`arctrue monte-carlo`](monte-carlo.md) draws table and inputs: {trials} trials of each "
        f"case, a capture as above ({plan['runs']} turn of {plan['samples']:,} samples),",
        "orders 1 to 32, 0.05″ to 0.3″ of noise. *Coverage*: share of trials with the truth within "
        "± 1.96 u, %. *Verdict*: whether the stated u holds within chance.",
        "",
        "| What acts | Stated u | Drawn | Drawn / stated | Coverage | Verdict |",
        "|---|---:|---:|---:|---:|---|",
        *rows,
        "",
        "- The covariance contains noise, quantisation and α, and holds for them. With α the "
        "coverage exceeds 95 %, because the error of α is rectangular: ± 1.96 u reach beyond its "
        "ends.",
        "- Quantisation alone is not white noise: its rounding errors average out better than "
        "those of a count over √12.",
        "- The covariance does not contain axis motion, which two heads attribute to the disc, nor "
        "a change of temperature within one turn, which the turn does not show;",
        "  with two runs it appears as their difference ([Monte Carlo](monte-carlo.md)).",
        "- Missing lanes, the rounding to a count, latency, ramp, subdivision and heat are sources "
        "of the table above, not of the covariance.",
        "",
    ]


def _experiment(found: Mapping[str, Any]) -> list[str]:
    rows = [
        f"| {one['quantity']} | {one['source']} | {one['type']} | {one['distribution']} | "
        f"{one['size_arcsec']:.4f} | {one['divisor']:.3f} | {one['sensitivity']:.3g} | "
        f"{one['u_arcsec']:.4f} | {_freedom(one['degrees_of_freedom'])} |"
        for one in found["rows"]
    ]
    compared = [
        f"| {name} | {one['U_own_arcsec']:.3f} | {one['U_polygon_arcsec']:.3f} | "
        f"{one['difference_rms_arcsec']:.3f} | {max(map(abs, one['e_n'])):.2f} | "
        f"{sum(abs(value) > 1.0 for value in one['e_n'])} of {len(one['e_n'])} |"
        for name, one in found["compared"].items()
    ]
    return [
        "## The experiment, after cg-23",
        "",
        f"A polygon that is remounted in each of {found['cycles']} cycles measures the table's "
        "error at a face. The closure separates faces and table",
        f"([methods](methods.md)), so that the certificate's 0.1″ does not enter: it estimates the "
        f"faces, {found['faces_arcsec']:.3f}″ RMS, with an error of "
        f"{found['faces_off_by_arcsec']:.3f}″.",
        "",
        "| Quantity | Source | Type | Distribution | Size, ″ | Divisor | cᵢ | uᵢ, ″ | νᵢ |",
        "|---|---|---|---|---:|---:|---:|---:|---:|",
        *rows,
        "",
        f"u = {found['u_arcsec']:.3f}″, U = {found['U_arcsec']:.2f}″ (k = 2; effective degrees of "
        f"freedom by Welch–Satterthwaite {_effective(found):,.0f}, so that k = 2 is 95.4 %). The "
        "paper's, with the",
        "certificate and the scatter of a single value, is 0.46″; without its two slips 0.26″ "
        "([errata](errata.md)).",
        "",
        f"Comparison of the self-calibration by two heads ({found['turns']} turns, least squares, "
        "α by the index) with that polygon, at 24 faces: E_n is the",
        "difference over √(U² + U²); results agree where |E_n| ≤ 1.",
        "",
        "| | U heads, ″ | U polygon, ″ | Difference, ″ RMS | Largest \\|E_n\\| | \\|E_n\\| > 1 |",
        "|---|---:|---:|---:|---:|---:|",
        *compared,
        "",
        "With k = 2, one of 24 faces is expected outside if both budgets hold, as they do with the "
        f"axis at rest. An axis motion of {found['radial_motion_m'] * 1e6:g} µm is in no",
        "line of the heads' budget, and E_n detects it: two heads attribute axis motion to the "
        "disc.",
        "",
    ]


def plot_error_budget(found: Mapping[str, Any], folder: Path) -> Path:
    """Draw every source as a bar, and the expanded uncertainty U over the angle."""
    path = folder / PICTURE
    own = found["methods"]["least_squares"]
    paper = found["methods"]["paper"]
    with house_style():
        figure = Figure(figsize=(9.6, 7.6), layout="constrained")
        bars, curve = figure.subplots(2, 1, height_ratios=[3, 2])
        place = np.arange(len(own["sources"]))
        for shift, one, colour, label in (
            (-0.2, paper, BEFORE, "the paper's method"),
            (0.2, own, AFTER, "least squares"),
        ):
            values = [max(row["rms_arcsec"], 1e-5) for row in one["sources"]]
            bars.barh(place + shift, values, 0.38, color=colour, label=label)
            bars.axvline(one["whole"]["rms_arcsec"], color=colour, linestyle=(0, (4, 3)))
        set_log_x(bars)
        bars.set_yticks(place, [row["title"] for row in own["sources"]], fontsize=8)
        bars.invert_yaxis()
        bars.set_xlabel("RMS, ″; broken: all sources together")
        bars.set_title("Each source alone")
        legend_below(bars, columns=2)
        for name, colour, label in (
            ("drawn", MUTED, "all sources, drawn"),
            ("covariance", AFTER, "in part: covariance of noise, quantisation and α"),
            ("of_alpha", BEFORE, "α alone"),
            ("of_noise", LIMIT, "noise and quantisation alone"),
        ):
            curve.plot(
                found["angle_deg"], own["by_angle"][f"{name}_arcsec"], color=colour, label=label
            )
        curve.set_ylim(bottom=0.0)
        curve.set_xlim(0, 360)
        curve.set_xticks(range(0, 361, 45))
        curve.set_xlabel("reading, °")
        curve.set_ylabel("2 u, ″")
        curve.set_title("Uncertainty over the turn: all sources, and the covariance")
        legend_below(curve, columns=2)
        return save_picture(figure, path)


def _value(arcsec: float) -> str:
    return f"{arcsec:.4f}" if arcsec >= 1e-4 else "< 0.0001"


def _with_u(one: Mapping[str, float]) -> str:
    """Format a value; add its standard error if this error changes a printed digit."""
    spread = one["u_rms_arcsec"]
    return _value(one["rms_arcsec"]) + (f" ± {spread:.4f}" if spread >= 5e-5 else "")


def _freedom(value: float | None) -> str:
    return "∞" if value is None else f"{value:.0f}"


def summary(found: Mapping[str, Any]) -> Sequence[tuple[str, float, float]]:
    """Return for every source its title, its RMS with the least-squares method and its RMS with the
    paper's method."""
    own, paper = (found["methods"][name]["sources"] for name in TITLES)
    return [
        (ours["title"], ours["rms_arcsec"], theirs["rms_arcsec"])
        for ours, theirs in zip(own, paper, strict=True)
    ]
