"""Makes the page of ``arctrue heads`` from its result."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

FAULT_TABLE = (
    "## A head that fails",
    "",
    "With the generic `FAILOVER` the gateware leaves a failed head out: it loads the prepared set "
    "without that head, carrier, weights, offsets and",
    "lanes, and swaps under the ramp ([head_failover](entities/head_failover.md)). All sets of "
    "four heads and 32 lanes fill one block RAM; loading one",
    "takes 4 · (4 · 32 + 10) + 4 clocks, 5.6 µs at 100 MHz. The first five rows are benches "
    "of `tb/core/failover_core_bench.py`, with four lanes and a short turn: no clock",
    "steps the output by more than 2 counts, which the table's own motion explains, and the mean "
    "of the three others is right afterwards. Figures are for 2²⁴ counts;",
    "w is the weight of the head, 0.28 at most at these places; a count is 0.077″.",
    "",
    "| Fault of a head | Found by | Within, with the loading | Output error until then |",
    "|---|---|---|---|",
    "| illegal step | its decoder | 20 clocks; 6 µs | w · 2 counts: 0.04″ |",
    "| too fast, or the filter swallows counts | its decoder | 20 clocks; 6 µs | w · 1 count a "
    "clock |",
    "| dead: stands while all others move | `missing_edges`, 48 counts | 48 counts and 5.6 µs: 17 "
    "µs at 90°/s, 5 ms at 0.2°/s; never at standstill | w · 72 counts: 1.5″ at 90°/s |",
    "| slips by 64 counts or more within 1.1 ms | `step_limit`, 32 counts, against all others | 20 "
    "clocks after the slip; 6 µs | w · slip |",
    "| slips by less | its index, or the parity over its limit (alarm only) | one turn | w · 63 "
    "counts: 1.4″ |",
    "| slips by up to the `index_tolerance` | not found | – | w · tolerance |",
    "| a second head fails | its decoder (alarm only); only sets without one head are prepared | – "
    "| not bounded |",
    "",
    "No place of a head is needed to tell a step from a motion of the axis: head k is "
    "named if the others agree within the limit without it, and",
    "without no other head. An axis that moves by 0.5 µm changes the difference of two heads on a "
    "radius of 100 mm by 26.8 counts; the eccentricity adds 3.8 in 1.31 ms at 90°/s. So a limit of "
    "32",
    "never names a wrong head, and a slip of 2 · 32 counts is always found; between 32 and 64 it "
    "depends on the motion. Faster tables and larger motions need a larger limit.",
    "",
    "A head comes back after its next index, on request or after `failover.return_after`, under "
    "the ramp; its index repeats to ± 1 count. A dead head shows no index and stays out.",
    "The parity Σcᵢ·rᵢ is read with a snapshot; on three heads it does not exist.",
    "The firmware writes no prepared sets yet, and switches the failover off before other "
    "coefficients become active.",
    "",
)
"""The faults of a head, as the benches of the gateware show them."""


def heads_page(found: Mapping[str, Any]) -> str:
    """Compose the page in Markdown."""
    balls, budget = found["ball_pass"], found["budget"]
    equal, unequal = found["hub_shift"]
    every, rest = found["error_function"]["rows"]
    missing = found["missing"]
    places = ", ".join(f"{place:g}°" for place in found["places_deg"])
    fine = ", ".join(f"{place:g}°" for place in found["error_function"]["places_deg"])
    zero = max(abs(one["zero_after_arcsec"]) for one in found["moved"])
    wrong = max(abs(one["wrong_by_arcsec"]) for one in found["moved"])
    return "\n".join(
        [
            "# Four heads and their mean",
            "",
            "The weighted mean of four heads, Σwᵢ = 1 and Σwᵢ·e^{jpᵢ} = 0, is free of "
            "translations of "
            "the axis and of the disc's centre, at every order",
            "and whether they repeat or not. The error of the disc in this mean is calibrated "
            "from the one "
            "combination of four readings that contains neither the",
            "table's motion nor that of the axis; the lanes correct it. `arctrue heads` "
            "calibrates a simulated table once and evaluates it on other",
            "turns, through the number formats of the gateware's mean; it made this page from "
            "[heads.json](data/heads.json).",
            "",
            "```sh",
            ".venv/bin/arctrue heads --page docs/heads.md --json docs/data/heads.json",
            "```",
            "",
            f"Four heads at {places} after head 1, two heads at 0°, 33°; mounting and detection "
            "of the index "
            "marks off by up to ± 50″; the disc of",
            f"[`arctrue revolution`](instrument.md); {found['samples_a_turn']:,} samples per turn, "
            "0.1″ of noise on each reading, counts of 0.077″. *Goal*: set before the "
            "study.",
            "",
            "| Other turns, nothing fitted | Two heads | Four heads | Goal |",
            "|---|---:|---:|---:|",
            "| Ball pass of 0.25 µm, axis at orders 2 and 3, calibrated with them: "
            f"attenuation of the balls | 1 | {balls['attenuation']:,.0f} | ≥ 500 |",
            f"| the same, RMS without noise, with counts | "
            f"{balls['two_heads_without_noise_rms_arcsec']:.3f}″ | "
            f"{balls['mean_without_noise_rms_arcsec']:.3f}″ | |",
            f"| the same, RMS with 0.1″ | {balls['two_heads_rms_arcsec']:.3f}″ | "
            f"{balls['mean_rms_arcsec']:.3f}″ | ≤ 0.06″ |",
            f"| the same, means over 20 samples | | {balls['mean_of_20_rms_arcsec']:.3f}″ | |",
            "| Disc's centre moves by 2 µm after the calibration, radii equal: change of the "
            f"output, RMS | {equal['on_head1_rms_arcsec']:.2f}″ | "
            f"{equal['on_mean_rms_arcsec']:.4f}″ | ≤ 0.005″ |",
            f"| the same, radii ± 0.1 mm | {unequal['on_head1_rms_arcsec']:.2f}″ | "
            f"{unequal['on_mean_rms_arcsec']:.4f}″ | ≤ 0.01″ |",
            f"| Error function, orders 2 to {every['orders']}, {every['turns']} turns, motion "
            f"unknown at every order, heads at {fine}: 2σ | – | "
            f"{every['left_2_sigma_arcsec']:.4f}″ ({every['expected_2_sigma_arcsec']:.4f}″ by the "
            "gains) | ≤ 0.045″ |",
            f"| the same, axis known to be at rest | – | {rest['left_2_sigma_arcsec']:.4f}″ "
            f"({rest['expected_2_sigma_arcsec']:.4f}″ by the gains) | ≤ 0.012″ |",
            "| A head moves by 100″ between two turns, the axis by 2 µm: the zero is off by | "
            f"{wrong:.0f}″ until the head is found | {zero:.3f}″ after | ≤ 0.05″ |",
            "",
            "The revolution in half-degree means of all edges is not part of this page.",
            "",
            *FAULT_TABLE,
            "## One head missing",
            "",
            "One new turn, evaluated with the weights of all heads and with those that leave one "
            "head out; the gateware stores all of them. *Lanes*: RMS of",
            "the disc's error that the lanes correct; it differs between the sets of weights, so "
            "that the "
            "lanes change with the weights. *Zero*: mean of the output relative to that of all "
            "heads.",
            "",
            "| Missing | Carrier | Weights | √Σwᵢ² | RMS, 0.1″ | without noise | Lanes | Zero |",
            "|---|---:|---|---:|---:|---:|---:|---:|",
            *(
                f"| {'none' if not one['missing'] else 'head ' + str(one['missing'])} | "
                f"{one['carrier']} | {', '.join(f'{w:.3f}' for w in one['weights'])} | "
                f"{one['noise']:.2f} | {one['rms_arcsec']:.3f}″ | "
                f"{one['without_noise_rms_arcsec']:.3f}″ | {one['lanes_rms_arcsec']:.2f}″ | "
                f"{one['zero_apart_arcsec']:+.4f}″ |"
                for one in missing
            ),
            "",
            "## A head that moved",
            "",
            "A head that moves along the scale changes its own offset; an axis that moves "
            "changes those of "
            "all heads. Four heads give three differences, which the motion of any one",
            "head together with some motion of the axis can explain. Only for the true head that "
            "motion is "
            "below 5 µm (`arctrue.calibration.moved_head`).",
            "",
            "| Moved by 100″ | Found | By | The mean's zero was off by | after |",
            "|---|---|---:|---:|---:|",
            *(
                f"| head {one['head']} | "
                f"{', '.join(f'head {head}' for head in one['found']) or 'none'} | "
                f"{one['moved_arcsec']:.3f}″ | {one['wrong_by_arcsec']:.1f}″ | "
                f"{one['zero_after_arcsec']:+.4f}″ |"
                for one in found["moved"]
            ),
            "",
            "## The error function over the number of turns",
            "",
            f"2σ of the disc's error over orders 2 to {every['orders']} from noise of 0.1″, whole "
            f"counts and {found['samples_a_turn']:,} samples a turn, by the noise gain of every "
            f"order at {fine}, places chosen for this row (low gains over all orders);",
            f"measured with {every['turns']} turns: {every['left_2_sigma_arcsec']:.4f}″ and "
            f"{rest['left_2_sigma_arcsec']:.4f}″, expected {every['expected_2_sigma_arcsec']:.4f}″ "
            f"and {rest['expected_2_sigma_arcsec']:.4f}″; each is one draw, with a standard "
            "deviation of 2 %. "
            "The cause of the remaining difference is unknown. Values below TDR's published "
            "0.006″ are",
            "better than TDR. Order 1 is left out: it contains the forward circle of the axis, "
            "and the mean "
            "does not contain order 1.",
            "",
            "| Turns | " + " | ".join(every["by_turns"]) + " |",
            "|---|" + "---:|" * len(every["by_turns"]),
            *(
                f"| {one['title']} | "
                + " | ".join(f"{value:.4f}″" for value in one["by_turns"].values())
                + " |"
                for one in (every, rest)
            ),
            "",
            "## Uncertainty of the mean by cause",
            "",
            "Standard uncertainties, one cause at a time.",
            "",
            "| Cause | u |",
            "|---|---:|",
            *(f"| {one['cause']} | {one['u_arcsec']:.4f}″ |" for one in budget),
            "",
            "The rounding of the output to whole counts exceeds the quantisation of the mean "
            "itself. "
            "The radii are unknowns of the calibration. It",
            "finds them if the axis is known to make no backward circle once per turn; otherwise "
            "give "
            "measured radii.",
            "",
        ]
    )
