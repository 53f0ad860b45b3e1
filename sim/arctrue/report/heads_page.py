"""Makes the page of ``arctrue heads`` from its result."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

FAULT_TABLE = (
    "## A head that fails",
    "",
    "With the generic `FAILOVER` the gateware leaves a failed head out: it loads the prepared set "
    "of carrier, weights, offsets and lanes without that head,",
    "and swaps under the ramp ([head_failover](entities/head_failover.md)). One block RAM holds "
    "all sets of four heads and 32 lanes; loading one set takes",
    "4 · (4 · 32 + 10) + 4 clocks, 5.6 µs at 100 MHz. The benches are cocotb tests of "
    "`tb/core/failover_core_bench.py`, with four lanes and a short turn:",
    "no clock steps the output by more than 2 counts, which the motion of the table explains, and "
    "afterwards the mean of the three other heads is right.",
    "Figures are for 2²⁴ counts, of 0.077″ each; w is the weight of the head, at most 0.28 at "
    "these places.",
    "",
    "| Fault of a head | Found by | Time until the swap | Output error until then | Bench |",
    "|---|---|---|---|---|",
    "| illegal step | its decoder | 20 clocks; 6 µs | w · 2 counts: 0.04″ | "
    "`an_illegal_step_leaves_a_head_out` |",
    "| too fast, or the filter swallows counts | its decoder | 20 clocks; 6 µs | w · 1 count a "
    "clock | `a_head_that_is_too_fast_is_left_out` |",
    "| dies or sticks: stands while all others move | `missing_edges`, 48 counts | 48 counts and "
    "5.6 µs: 17 µs at 90°/s, 5 ms at 0.2°/s; never at standstill | w · 72 counts: 1.5″ at 90°/s | "
    "`a_dead_carrier_is_left_out` |",
    "| slips by 64 counts or more within 1.1 ms, up to any size | `step_limit`, 32 counts, against "
    "all others | 20 clocks and 5.6 µs after the first 64 counts | w · (64 counts and those "
    "of 6 µs), at most w · slip: 5″ for 4,000 counts at 4 clocks a count | "
    "`a_head_that_steps_against_the_others_is_left_out` (80 counts); 4,000 counts, which may "
    "also show as illegal steps: `sim/tests/instrument/test_failover.py` |",
    "| slips by less | its index, or the parity over its limit (alarm only) | one turn | w · 63 "
    "counts: 1.4″ | `a_small_slip_is_found_at_the_index`, `the_parity_shows_a_slip_at_once` |",
    "| slips by up to the `index_tolerance` | not found | – | w · tolerance | "
    "`no_head_fails_without_a_fault` |",
    "| a second head fails | its decoder (alarm only); only sets without one head are prepared | – "
    "| not bounded | `tb/mean/head_failover_bench.py` |",
    "| none: a head returns after its index | – | on request or after a time | none | "
    "`a_head_comes_back_after_its_index` |",
    "| none: words that use the dead head are swapped or loaded | the gateware refuses them | – | "
    "none | `a_swap_does_not_bring_a_dead_head_back`, "
    "`a_set_that_uses_the_failed_head_is_not_taken` |",
    "",
    "Proved for every sequence of inputs ([proofs](proofs.md)): A and B of the output never change "
    "together, whatever angle and position are to be put out, so that no change of a set",
    "makes an illegal step; a set is swapped whole, over lanes, weights and offsets; a head that "
    "is left out has no weight, and is back only after its index.",
    "",
    "The gateware separates a step of a head from a motion of the axis without knowing the places "
    "of the heads: head k has failed if the other heads agree",
    "within the limit, and if that holds for no other choice of k. An axis motion of 0.5 µm "
    "changes the difference of two heads on a radius of 100 mm by 26.8 counts;",
    "eccentricity adds 3.8 counts in 1.31 ms at 90°/s. A limit of 32 counts therefore never names "
    "a wrong head. A slip of 2 · 32 counts is always found; a slip of",
    "32 to 64 counts is found or not, depending on the motion. Faster tables and larger motions "
    "need a larger limit.",
    "",
    "A head returns under the ramp after its next index, on request or after "
    "`failover.return_after`; its index repeats to ± 1 count. A dead head has no index and",
    "does not return. A snapshot reads the parity Σcᵢ·rᵢ, which exists for four heads only. "
    "The device makes the sets itself, or `arctrue load` loads them; the",
    "console's `come_back` returns a head ([firmware](firmware-load.md#three-and-four-heads)).",
    "",
)
"""Section about the faults of a head; the gateware's testbenches measured its numbers."""
DEVICE = (
    "## Calibrated by the device",
    "",
    "With the places of all heads the [firmware](firmware.md#three-and-four-heads) calibrates the "
    "mean of three or four heads from captured turns and corrects it.",
    "`arctrue revolution --heads 4` runs this on the compiled gateware. The firmware's C with the "
    "gateware's mean bit for bit, calibrated on one turn at the paper's",
    "conditions (2²⁴ counts, 12,000 samples, 0.2″ on each reading; heads 50″, 30″ and 40″ off "
    "their places), left means of half a degree within −0.044″ and",
    "+0.051″, 0.013″ RMS, on another turn, the worst of ten draws; the goal is ± 0.07″ and 0.022″ "
    "(`sim/tests/firmware/test_heads.py`). Index marks repeat exactly in this case.",
    "`arctrue revolution --heads 4` at full size, every edge through the compiled gateware, left "
    "−0.046″ to +0.047″ and 0.016″ RMS (8 minutes); with `--lines 4096` ±0.059″ and 0.018″.",
    "",
    "With four heads and the generic `FAILOVER` the device also makes the sets for a missing head, "
    "with every swap, and switches the failover on. Calibrated on one turn of",
    "6,000 samples with 0.1″ and an axis that moves, they leave 0.012″ RMS (all heads) and 0.015″ "
    "to 0.020″ (one missing) on another turn without noise; the zeros agree to",
    "0.001″ (`sim/tests/firmware/test_own_sets.py`). On the compiled instrument head 3 dies and "
    "the output stays right (`sim/tests/instrument/test_failover.py`).",
    "",
)
"""Section about the calibration by the firmware; the firmware's tests measured its numbers."""
OBSERVABLE = (
    "## What three and four heads determine",
    "",
    "At order n a reading contains the motion of the table, the disc, and the motion of the axis "
    "in two directions: four unknowns. One turn, and any number of turns that repeat,",
    "gives one equation a head. The tests of `sim/tests/calibration/test_observable_by_heads.py` "
    "show each row for the heads of this page and for three at 0°, 118°, 237°.",
    "",
    "| Heads | Disc and axis |",
    "|---|---|",
    "| four | separate at every order from 2 on, except where the gain of the places is infinite. "
    "At order 1 the forward circle of the axis equals an eccentric disc, which the mean does not "
    "contain |",
    "| three | separate at no order: every disc has an axis and a table motion with the same three "
    "readings at every moment. No method can separate them without a further head, another "
    "position of the disc on the axis, or the knowledge that the axis is at rest at the order |",
    "| three, motion that does not repeat from turn to turn | averages out |",
    "",
    "The mean of three heads contains no motion of the axis, but the lanes put in what the "
    "calibration took for the disc: per 1″ of motion 0.02″ to 0.05″ at orders 2, 4 and 5, and 10″ "
    "at order 3, 5″ at order 6,",
    "which heads near 120° hardly see (noise gain 8.9 and 4.4) and whose disc error their mean has "
    "in full. Lower `gain_limit` below these gains where the axis moves, or use a fourth head.",
    "",
)
"""Section about the errors that the heads determine, and the tests that prove it."""


def heads_page(found: Mapping[str, Any]) -> str:
    """Return the page as Markdown."""
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
            "The weighted mean of four heads, with Σwᵢ = 1 and Σwᵢ·e^{jpᵢ} = 0, does not change "
            "when the axis or the centre of the disc moves, at any order and whether",
            "the motion repeats or not. One combination of the four readings contains neither the "
            "motion of the table nor that of the axis: it calibrates the",
            "disc's error in the mean, and the lanes correct this error. `arctrue heads` "
            "calibrates a simulated table once and evaluates it on other turns, with",
            "the number formats of the gateware's mean. It made this page from "
            "[heads.json](data/heads.json).",
            "",
            "```sh",
            ".venv/bin/arctrue heads --page docs/heads.md --json docs/data/heads.json",
            "```",
            "",
            "| Setting | Value |",
            "|---|---|",
            f"| four heads, after head 1 | {places} |",
            "| two heads | 0°, 33° |",
            "| errors of mounting and index marks | up to ± 50″ |",
            "| disc | as in [`arctrue revolution`](instrument.md) |",
            f"| samples | {found['samples_a_turn']:,} per turn, noise of 0.1″ on each reading, "
            "counts of 0.077″ |",
            "| goal | set before the study |",
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
            *DEVICE,
            *OBSERVABLE,
            *FAULT_TABLE,
            "## One head missing",
            "",
            "One new turn is evaluated with the weights of all heads and with those that leave "
            "one head out; the gateware stores all of them. *Lanes* is the RMS of the",
            "disc's error, which differs between the weights, so that each set of weights has its "
            "own lanes. *Zero* is the mean of the output relative to that of all heads.",
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
            "A head that moves along the scale changes its own offset; an axis that moves changes "
            "the offsets of all heads. Four heads give three differences, which the",
            "motion of any one head together with some motion of the axis explains. The motion of "
            "the axis is below 5 µm for the true head only (`arctrue.calibration.moved_head`).",
            "The firmware that calibrates its own mean does this in every turn: it shifts the "
            "offset of that head, and telemetry has `moved_head` and `moved_arcsec`.",
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
            f"2σ of the disc's error over orders 2 to {every['orders']}, calculated from the noise "
            f"gain of every order at {fine}, for noise of 0.1″, whole counts and "
            f"{found['samples_a_turn']:,} samples per turn.",
            "These places have low gains over all orders. Order 1 is omitted: the mean does not "
            "contain it, and the forward circle of the axis looks the same.",
            f"With {every['turns']} turns the study measured {every['left_2_sigma_arcsec']:.4f}″ "
            f"and {rest['left_2_sigma_arcsec']:.4f}″ where {every['expected_2_sigma_arcsec']:.4f}″ "
            f"and {rest['expected_2_sigma_arcsec']:.4f}″ were expected; each is one draw with a "
            "standard deviation",
            "of 2 %. The cause of the difference is unknown. The published value of "
            "[time measurement on a free spin](methods.md) is 0.006″.",
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
            "The rounding of the output to whole counts exceeds the quantisation of the mean. "
            "The calibration fits the radii if the axis is known to make no backward",
            "circle once per turn; otherwise give it measured radii.",
            "",
        ]
    )
