"""Makes the page of ``arctrue error-sources`` from its result."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from arctrue.base.percent import percent
from arctrue.report.charts.error_budget_picture import PICTURE

TITLES = {"least_squares": "least squares (`arctrue calibrate`)", "paper": "the paper's method"}


def error_budget_page(found: Mapping[str, Any]) -> str:
    """Return the page as Markdown."""
    return "\n".join(
        [
            "# Budget of the calibration",
            "",
            "This page shows which sources of error limit the corrected angle. `arctrue "
            "error-sources` simulates every source alone, then all sources together,",
            "and compares the uncertainty that the calibration states with the errors of random "
            "calibrations. The last section is the budget of the paper's experiment",
            "in the form of EURAMET cg-23. The command makes this page from "
            "[calibration-budget.json](data/calibration-budget.json).",
            "",
            "```sh",
            ".venv/bin/arctrue error-sources --page docs/calibration-budget.md "
            "--json docs/data/calibration-budget.json --out docs/images",
            *_command_of_drawn(found),
            ".venv/bin/arctrue budget SET          # for your own set; --json writes U every 5°",
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
        "| … of which order 11 alone | noise gain 19 | "
        f"{_value(noise['of_weak_order_arcsec'])} | "
        f"{_value(paper['sources'][1]['of_weak_order_arcsec'])} |",
    )
    largest = max(own["sources"], key=lambda one: one["rms_arcsec"])
    return [
        "## By source",
        "",
        "The last two columns are the RMS over the turn of the remaining error of head 1, in ″. "
        f"For a random source they are the root mean square of {found['draws']} draws ± its "
        "standard error.",
        "The simulated rotary table is that of [`arctrue revolution`](instrument.md) with an added "
        "0.4″ of order 11; each calibration uses one turn of 12,000 samples, orders 1 to 16",
        f"and 2²⁴ counts. Without any source of error, {own['exact_rms_arcsec']:.0e}″ (least "
        f"squares) and {paper['exact_rms_arcsec']:.0e}″ (the paper's method) remain.",
        "",
        f"| Source | Size | {TITLES['least_squares']} | {TITLES['paper']} |",
        "|---|---|---:|---:|",
        *rows,
        f"| **root of the sum of squares** | | {_value(own['sum_arcsec'])} | "
        f"{_value(paper['sum_arcsec'])} |",
        f"| **all simulated together** | | {_with_u(own['whole'])} | {_with_u(paper['whole'])} |",
        "",
        f"- The largest source is {largest['title']}: this error repeats with the lines of the "
        "disc, so that no calibration of the orders 1 to 16 removes it. Its size is",
        "  assumed; the effect [`subdivision_error`](effects.md#subdivision_error) estimates the "
        "size for a real table.",
        *_sum_and_whole(found),
        f"- The transfer function predicts the row *noise of the readings* without a simulation: "
        f"0.1″ · √(4 Σ |TF(n)|² / 12,000) = {noise['expected_arcsec']:.4f}″.",
        f"- Order 11 alone contributes {percent(share)} of the variance of this noise, because two "
        "heads at α = 33° determine order 11 poorly: see "
        "[the angle between the heads](head-angle.md).",
        "- The paper's method adds the errors of uneven sampling and of the approximation in its "
        "equation (8); "
        "least squares at the actual readings has neither error.",
        "- Error of α: the repeatability of the index is negligible; the places where the two "
        "heads *detect* the index mark determine the error. The key `table.index_detection_arcsec` "
        "states the standard uncertainty of the distance between these places.",
        f"- Without recalibration the table's error changes by "
        f"{found['heat_not_recalibrated_arcsec_per_k']:.1f}″ per kelvin: a change of 2 K causes "
        f"{2 * found['heat_not_recalibrated_arcsec_per_k']:.0f}″, "
        f"{2 * found['heat_not_recalibrated_arcsec_per_k'] / own['whole']['rms_arcsec']:.0f} times "
        "the error of all sources above.",
        f"- The ramp changes the correction by {found['ramp_rate_arcsec_s']:.0f}″ per second: the "
        f"first correction, 150″, is reached after {150 / found['ramp_rate_arcsec_s']:.1f} s, and "
        "a later small change after a millisecond.",
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
        "- The root of the sum of squares differs from the result of all sources together by "
        f"{100 * shares[0]:+.1f} % and {100 * shares[1]:+.1f} %, which are {abs(errors[0]):.1f} "
        f"and {abs(errors[1]):.1f} standard errors of the difference. The sources are nearly "
        "independent.",
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
        "quantisation and α; an error of α, which is measured by the index, changes all orders "
        "together.",
        f"Twice this uncertainty (`Estimate.u_error_arcsec`) is {covariance.min():.3f}″ to "
        f"{covariance.max():.3f}″; tests compare this uncertainty with the errors of random "
        "calibrations. Twice the RMS of the remaining error with all sources is",
        f"{drawn.min():.2f}″ to {drawn.max():.2f}″. Only this second value is an expanded "
        "uncertainty U (k = 2) of the corrected angle, valid for the sizes of the sources above.",
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
        "## The covariance compared with random calibrations",
        "",
        "[`arctrue monte-carlo`](monte-carlo.md) draws the table and its inputs at random: "
        f"{trials} trials of each case, with {plan['runs']} turn of {plan['samples']:,} samples, "
        "orders 1 to 32 and 0.05″ to 0.3″ of noise.",
        "*Stated u* is the RMS over the turn of the standard uncertainty of ε that the calibration "
        "states. *Deviation* is the RMS of (calibrated ε − true ε) over turn and trials.",
        "*Coverage* is the share of angles and trials at which the true ε lies within ± 1.96 u of "
        "the calibrated ε. *Verdict* states whether u agrees with the coverage within "
        "chance.",
        "",
        "| Active inputs | Stated u, ″ | Deviation, ″ | Deviation / stated u | Coverage, % | "
        "Verdict |",
        "|---|---:|---:|---:|---:|---|",
        *rows,
        "",
        "- The covariance contains noise, quantisation and α, and its uncertainty is large enough "
        "for these inputs. With α the coverage exceeds 95 %, because the error of α has a "
        "rectangular distribution, which lies entirely within ± 1.96 u.",
        "- Quantisation alone is not white noise: its rounding errors average out better than "
        "white noise with a standard deviation of a count/√12.",
        "- The covariance contains neither axis motion (two heads attribute it to the disc) nor a "
        "temperature change within the turn (one turn does not show it; two runs then differ, see "
        "[Monte Carlo](monte-carlo.md)).",
        "- The covariance does not contain missing lanes, the rounding of the output to a count, "
        "latency, ramp, subdivision and heat: the first table contains these sources.",
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
        "## The paper's experiment in the form of cg-23",
        "",
        f"A polygon, which is remounted in each of {found['cycles']} cycles, measures the table's "
        "error at each face. In every cycle the polygon stands at another angle on the table. "
        "Therefore a closure can separate the faces' errors from the table's error",
        "([methods](methods.md)), and the 0.1″ of the polygon's certificate are not needed: "
        f"the closure estimates the faces' errors, {found['faces_arcsec']:.3f}″ RMS, with an error "
        f"of {found['faces_off_by_arcsec']:.3f}″.",
        "",
        "| Quantity | Source | Type | Distribution | Size, ″ | Divisor | cᵢ | uᵢ, ″ | νᵢ |",
        "|---|---|---|---|---:|---:|---:|---:|---:|",
        *rows,
        "",
        f"The budget gives u = {found['u_arcsec']:.3f}″ and U = {found['U_arcsec']:.2f}″ (k = 2; "
        f"effective degrees of freedom by Welch–Satterthwaite {_effective(found):,.0f}, so that "
        "k = 2 is 95.4 %).",
        "The paper's U, which uses the certificate and the scatter of a single value, is 0.46″; "
        "without the paper's two mistakes it is 0.26″ ([errata](errata.md)).",
        "",
        "The next table compares the self-calibration by two heads "
        f"({found['turns']} turns, least squares, α measured by the index) with this polygon, at "
        "24 faces.",
        "E_n is the difference divided by √(U_heads² + U_polygon²); two results agree if "
        "|E_n| ≤ 1.",
        "",
        "| Axis | U heads, ″ | U polygon, ″ | Difference, ″ RMS | Largest \\|E_n\\| | "
        "Faces with \\|E_n\\| > 1 |",
        "|---|---:|---:|---:|---:|---:|",
        *compared,
        "",
        "With k = 2 and two correct budgets, |E_n| > 1 is expected at one of 24 faces; the result "
        "with the axis at rest agrees with this. The heads' budget has no line for the axis "
        f"motion of {found['radial_motion_m'] * 1e6:g} µm,",
        "which two heads attribute to the disc; E_n detects this motion.",
        "",
    ]


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
