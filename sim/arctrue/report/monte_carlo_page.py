"""Makes the page of the coverage study, which shows for each case whether the stated uncertainty is
right."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from arctrue.studies.campaign.store import stated_code
from arctrue.studies.monte_carlo.inputs import CASES, INPUTS
from arctrue.studies.monte_carlo.trial import ECCENTRICITY_UM, GRADUATION_ARCSEC

HEAD = """# Coverage of the stated uncertainty

`arctrue monte-carlo` is a coverage study over random tables. Each trial draws a table and all input
quantities, simulates a capture of two heads, runs `arctrue calibrate`, and compares the result with
the truth. *Coverage* is the share of trials in which the truth lies in the stated 95 % region:

| Quantity | Region |
|---|---|
| an order | the ellipse of its cosine and sine in their stated covariance |
| the error at a reading | ±1.96 u |
| α | ±1.65 u, since its error is rectangular |

The study is not the propagation of distributions of supplement 1 of the GUM (JCGM 101:2008). That
method starts from the estimates of one measurement and gives the distribution of its measurand, a
coverage interval and a numerical tolerance (clause 7.9). Here the tables differ from trial to
trial, and the result is the share of intervals that hold.

    arctrue monte-carlo FOLDER --trials 400          # --workers N, --scheduler ADDRESS, --shard i/n
    arctrue monte-carlo FOLDER --trials 400 --page docs/monte-carlo.md

The second command made this page. An interrupted calculation continues when the command is
repeated ([campaigns](campaigns.md)).
"""

READING = """## How to read it

- The truth is the error R₁ − θ of head 1 as a function of its reading, at the mean temperature of
  the capture. It includes radial motion, which moves the reading.
- A deviation is the stated value minus the truth.
- An uncertainty is *too small* or *too large* if chance explains its coverage with a probability
  below 1 %, over all figures of one case.
- *Estimate* is the sum of all fitted orders. *Corrected* is the angle after the bit-true gateware,
  with the available lanes and whole counts. It is compared with the u of the estimate, which does
  not contain these two.
- A trial has the same table and the same draws in every case, so that cases differ by their inputs
  alone. `quantisation` has no other input: whole counts of 2²⁴ a turn and the gateware's words,
  which act in all other cases too.
"""


def monte_carlo_page(header: Mapping[str, Any], found: Mapping[str, Any]) -> str:
    """Return the page as Markdown, from the header of the campaign and the scores."""
    plan, code = header["plan"], header["code"]
    libraries = ", ".join(f"{name} {code[name]}" for name in sorted(code) if name != "arctrue")
    number = max(case["trials"] for case in found.values())
    part = "" if number == plan["trials"] else f" (of {plan['trials']}: the run was stopped)"
    runs, turns = _number(plan["runs"], "run"), _number(plan["turns"], "turn")
    lines = [HEAD, "## Result", ""]
    lines += [
        f"{number} trials of each case{part}, seed {plan['seed']}; {runs} of {turns} with "
        f"{plan['samples']:,} samples a turn, method {plan['method']}. "
        f"{stated_code(header)}; {libraries}.",
        "",
        *_summary(found),
        "",
        "### Where the stated uncertainty is off",
        "",
        *where_off(found),
        "",
        "### By order",
        "",
        *_orders(found),
        "",
        "## What is drawn",
        "",
        f"The table: a disc {ECCENTRICITY_UM[0]:g} … {ECCENTRICITY_UM[1]:g} µm off the axis, and "
        f"graduation errors of orders 2 to 20, {GRADUATION_ARCSEC[0]:g} … "
        f"{GRADUATION_ARCSEC[1]:g}″ each, log-uniform.",
        "",
        "| input | drawn |",
        "|---|---|",
        *(f"| {item.title} | {item.distribution} |" for item in INPUTS.values()),
        "",
        READING.rstrip(),
        "",
    ]
    return "\n".join(lines)


def _number(number: int, what: str) -> str:
    return f"{number} {what}{'s' if number > 1 else ''}"


def _title(case: str) -> str:
    if not CASES[case]:
        return "quantisation alone"
    if case == "all":
        return "all"
    added = [name for name in CASES[case] if name != "noise"]
    return f"noise, {INPUTS[added[0]].title}" if added else "noise"


def _summary(found: Mapping[str, Any]) -> list[str]:
    lines = [
        "| inputs that act | coverage of orders, mean (least) % | of α % | of the estimate over "
        "the turn % | of the corrected angle % | deviation of the estimate, RMS ″ | "
        "stated u, RMS ″ | corrected, RMS ″ | refused |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for case, of in found.items():
        refused = ", ".join(f"{name} {number}" for name, number in of["refused"].items())
        if "orders" not in of:
            lines.append(f"| {_title(case)} |  |  |  |  |  |  |  | {refused} |")
            continue
        rates = [order["rate"] for order in of["orders"]]
        least = min(of["orders"], key=lambda order: order["rate"])
        turn, corrected = of["turn"], of["corrected"]
        lines.append(
            f"| {_title(case)} | {100 * sum(rates) / len(rates):.1f} "
            f"({100 * least['rate']:.1f}, order {least['order']}) | "
            f"{_alpha(of)} | {100 * turn['rate']:.1f} ± "
            f"{100 * turn['standard_error']:.1f} | {100 * corrected['rate']:.1f} ± "
            f"{100 * corrected['standard_error']:.1f} | {turn['rms_deviation_arcsec']:.4f} | "
            f"{turn['rms_stated_arcsec']:.4f} | {corrected['rms_deviation_arcsec']:.4f} | "
            f"{refused or '0'} |"
        )
    return lines


def _alpha(of: Mapping[str, Any]) -> str:
    return "–" if of["alpha"] is None else f"{100 * of['alpha']['rate']:.1f}"


def where_off(found: Mapping[str, Any]) -> list[str]:
    """Return a line for each case with a wrong stated uncertainty; if there is none, return one
    sentence."""
    lines = []
    for case, of in found.items():
        if "orders" not in of:
            continue
        verdicts = []
        for verdict in ("too small", "too large"):
            orders = [
                f"{order['order']} ({100 * order['rate']:.0f} %)"
                for order in of["orders"]
                if order["stated_uncertainty"] == verdict
            ]
            if orders:
                verdicts.append(f"{verdict} at order{'s' * (len(orders) > 1)} {', '.join(orders)}")
            for name, title in (
                ("alpha", "α"),
                ("turn", "the estimate over the turn"),
                ("corrected", "the corrected angle"),
            ):
                if of[name] is not None and of[name]["stated_uncertainty"] == verdict:
                    verdicts.append(
                        f"{verdict} for {title}: coverage {100 * of[name]['rate']:.1f} %, "
                        f"deviation {of[name]['rms_deviation_arcsec']:.4f}″ RMS, "
                        f"stated {of[name]['rms_stated_arcsec']:.4f}″"
                    )
        if verdicts:
            lines.append(f"- {_title(case)}: {'; '.join(verdicts)}.")
    return lines or ["Nowhere: each coverage agrees with 95 % within chance."]


def _orders(found: Mapping[str, Any]) -> list[str]:
    shown = [name for name, of in found.items() if "orders" in of]
    if not shown:
        return ["Every capture was refused."]
    head = " | ".join(_title(name) for name in shown)
    lines = [
        "Coverage, percent; in brackets deviation and stated u of a component, RMS, 10⁻³ ″.",
        "",
        f"| order | {head} |",
        "|---|" + "---|" * len(shown),
    ]
    for at in range(len(found[shown[0]]["orders"])):
        cells = [_cell(found[name]["orders"][at]) for name in shown]
        lines.append(f"| {at + 1} | " + " | ".join(cells) + " |")
    return lines


def _cell(order: Mapping[str, Any]) -> str:
    deviation, stated = order["rms_deviation_arcsec"], order["rms_stated_arcsec"]
    text = f"{100 * order['rate']:.1f} ({1e3 * deviation:.2g}; {1e3 * stated:.2g})"
    return text if order["stated_uncertainty"] == "holds" else f"**{text}**"
