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
the true value. *Coverage* is the share of trials in which the true value lies in the stated 95 %
region:

| Quantity | Region |
|---|---|
| an order | the ellipse that the stated covariance of its cosine and sine gives |
| the error at a reading | ±1.96 u |
| α | ±1.65 u, because the error of α has a rectangular distribution |

The study is not the propagation of distributions of supplement 1 of the GUM (JCGM 101:2008). That
method starts from the estimates of one measurement and gives the distribution of its measurand, a
coverage interval and a numerical tolerance (clause 7.9). Here the tables differ from trial to
trial, and the result is the share of intervals that contain the true value.

    arctrue monte-carlo FOLDER --trials 400          # --workers N, --scheduler ADDRESS, --shard i/n
    arctrue monte-carlo FOLDER --trials 400 --page docs/monte-carlo.md

The second command made this page. An interrupted calculation continues when the command is
repeated ([campaigns](campaigns.md)).
"""

READING = """## How to read it

- The true value is the error R₁ − θ of head 1 as a function of its reading, at the mean temperature
  of the capture. The error includes the effect of radial motion on the reading.
- A deviation is the stated value minus the true value. The number after ± is the standard error of
  a coverage.
- A stated uncertainty is *too small* or *too large* if its coverage differs from 95 % by more than
  chance explains. Over all figures of one case, the probability of such a difference is below 1 %.
- *Estimate* is the sum of all fitted orders. *Corrected angle* is the output of the bit-true
  gateware, with the available lanes and rounded to whole counts. Its deviation is compared with the
  u of the estimate, which contains neither missing lanes nor this rounding.
- Trial number n has the same table and the same random values in every case, so that the cases
  differ by their active inputs only. The case *quantisation alone* has only the rounding of the
  readings to counts (2²⁴ per turn) and the rounding in the gateware; both are also active in all
  other cases.
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
        f"{plan['samples']:,} samples per turn, method {plan['method']}. "
        f"{stated_code(header)}; {libraries}.",
        "",
        *_summary(found),
        "",
        "### Where the stated uncertainty is wrong",
        "",
        *where_off(found),
        "",
        "### By order",
        "",
        *_orders(found),
        "",
        "## What is drawn",
        "",
        f"The centre of the table's disc lies {ECCENTRICITY_UM[0]:g} … {ECCENTRICITY_UM[1]:g} µm "
        "off the axis (rectangular distribution). The disc has graduation errors of orders 2 to "
        f"20, with amplitudes of {GRADUATION_ARCSEC[0]:g} … {GRADUATION_ARCSEC[1]:g}″ each "
        "(log-uniform).",
        "",
        "| Input | Distribution |",
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
        "| active inputs | coverage of the orders: mean (smallest), % | coverage of α, % | "
        "coverage of the estimate over the turn, % | coverage of the corrected angle, % | RMS "
        "deviation of the estimate, ″ | RMS stated u, ″ | RMS deviation of the corrected angle, ″ "
        "| refused captures |",
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
                        f"stated u {of[name]['rms_stated_arcsec']:.4f}″"
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
        "Each cell shows the coverage in % and, in brackets, the RMS deviation and the RMS stated "
        "u of a component (cosine or sine) in 10⁻³ ″. In bold cells the stated u is too small or "
        "too large.",
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
