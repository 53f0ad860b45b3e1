"""Makes the page of ``arctrue heads`` from its result."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

FAULT_TABLE = (
    "## A head that fails",
    "",
    "With the generic `FAILOVER` the gateware removes a failed head from the mean: it loads the "
    "set that was prepared for the other heads, which contains carrier (the head whose reading the",
    "output follows), weights, offsets and lanes, and swaps to this set; a ramp limits the "
    "output's change ([head_failover](entities/head_failover.md)). One block RAM holds all sets of "
    "four heads and 32 lanes; loading one set takes",
    "4 · (4 · 32 + 10) + 4 clocks, 5.6 µs at 100 MHz. The benches in the table are cocotb tests of "
    "`tb/core/failover_core_bench.py`, with four lanes and a short turn. They show",
    "that the output steps by at most 2 counts in a clock, one count of motion and one count of "
    "rounding, and that after the swap the mean of the three other heads is correct.",
    "The figures are for 2²⁴ counts of 0.077″; w is the weight of the failed head, at most 0.28 at "
    "these places.",
    "",
    "| Fault of a head | Detected by | Time until the swap | Output error until the swap | Bench |",
    "|---|---|---|---|---|",
    "| illegal step | the head's decoder | 20 clocks and 5.6 µs: 6 µs | w · 2 counts: 0.04″ | "
    "`an_illegal_step_leaves_a_head_out` |",
    "| signals are too fast, or the glitch filter suppresses counts | the head's decoder | 20 "
    "clocks and 5.6 µs: 6 µs | w · 1 count per clock | `a_head_that_is_too_fast_is_left_out` |",
    "| signals are dead or stuck: the count stands while all other heads move | `missing_edges`, "
    "48 counts | 48 counts and 5.6 µs: 17 µs at 90°/s, 5 ms at 0.2°/s; never at standstill | w · "
    "72 counts: 1.5″ at 90°/s | `a_dead_carrier_is_left_out` |",
    "| slip of 64 counts or more within 1.1 ms | comparison with all other heads: `step_limit`, "
    "32 counts | 20 clocks and 5.6 µs after the first 64 counts | w · (64 counts and the counts "
    "that slip in 6 µs), at most w · slip: 5″ for 4,000 counts at 4 clocks per count | "
    "`a_head_that_steps_against_the_others_is_left_out` (80 counts); "
    "`sim/tests/instrument/test_failover.py` (4,000 counts, which may also appear as illegal "
    "steps) |",
    "| slip of less than 64 counts | the head's index; or the parity exceeds its limit (alarm "
    "only) | one turn | w · 63 counts: 1.4″ | `a_small_slip_is_found_at_the_index`, "
    "`the_parity_shows_a_slip_at_once` |",
    "| slip of at most `index_tolerance` | not detected | – | w · tolerance | "
    "`no_head_fails_without_a_fault` |",
    "| one fault hits several heads, for example because the table is too fast | the heads' "
    "decoders | 6 µs; the gateware removes only the first head; if several fail in one clock, "
    "the one with the lowest number | the counts that the other heads lost, until their indices | "
    "`a_fault_of_all_heads_leaves_one_out` |",
    "| a second head fails | the head's decoder (alarm only); the prepared sets omit only one head "
    "| – | not bounded | `tb/mean/head_failover_bench.py` |",
    "| no fault: a head returns after its index | – | on request or after a set time | none | "
    "`a_head_comes_back_after_its_index` |",
    "| no fault: the firmware swaps or loads words that use the failed head | the gateware refuses "
    "these words | – | none | `a_swap_does_not_bring_a_dead_head_back`, "
    "`a_set_that_uses_the_failed_head_is_not_taken` |",
    "",
    "Formal [proofs](proofs.md) show for every sequence of inputs: A and B of the output never "
    "change together, for any requested angle and position, so that no swap of a set",
    "causes an illegal step; lanes, weights and offsets of a set are swapped together; a removed "
    "head has the weight 0 and returns only after its index.",
    "",
    "The gateware distinguishes a step of a head from axis motion without the places of the heads: "
    "it removes head k if the readings of all other heads changed equally, within the limit,",
    "and if head k is the only head for which this is true. Axis motion of 0.5 µm changes the "
    "difference of two heads on a radius of 100 mm by up to 26.7 counts (at 2²⁴ counts per turn, "
    "on a radius r, by 2670 counts · mm / r); eccentricity adds 3.8 counts",
    "in 1.31 ms at 90°/s. Under these conditions, with a limit of 32 counts, the gateware never "
    "removes a wrong head and always detects a slip of 2 · 32 counts or more;",
    "whether it detects a slip of 32 to 64 counts depends on the motion. Faster tables, larger "
    "motions and smaller discs need a larger `failover_step_counts`: 64 for r = 54 mm, where the "
    "axis motion causes 49.4 counts.",
    "",
    "A removed head returns to the mean on request (console command `come_back`) or after the time "
    "`failover.return_after`, as soon as it has seen its next index; the ramp spreads the",
    "change; the index repeats within ± 1 count. A dead head sees no index and does not return. "
    "A snapshot contains the parity Σcᵢ·rᵢ of the readings rᵢ, which neither table motion nor",
    "axis motion changes; it exists for four heads only. The device computes the prepared sets "
    "itself, or `arctrue load` loads them ([firmware](firmware-load.md#three-and-four-heads)).",
    "",
)
"""Section about the faults of a head; the gateware's testbenches measured its numbers."""
DEVICE = (
    "## Calibrated by the device",
    "",
    "If the places of all heads are known, the [firmware](firmware.md#three-and-four-heads) "
    "calibrates the mean of three or four heads from captured turns and corrects this mean.",
    "A test calibrates with the firmware's C code and a bit-true model of the gateware's mean on "
    "one turn at the paper's conditions (2²⁴ counts, 12,000 samples, 0.2″ of noise",
    "on each reading; heads 50″, 30″ and 40″ off their places; index marks that repeat exactly) "
    "and evaluates another turn. In the worst of ten draws the remaining error, averaged",
    "over half a degree, is −0.044″ to +0.051″ and 0.013″ RMS; the goal is ± 0.07″ and 0.022″ RMS "
    "(`sim/tests/firmware/test_heads.py`).",
    "`arctrue revolution --heads 4` sends every edge through the compiled gateware: at full size "
    "−0.046″ to +0.047″ and 0.016″ RMS remain (8 minutes); with `--lines 4096` ±0.059″ and 0.018″ "
    "RMS.",
    "",
    "With four heads and the generic `FAILOVER` the device also computes, at every swap, the sets "
    "for one missing head, and then switches the failover on. A test calibrates on one turn of",
    "6,000 samples with 0.1″ of noise and axis motion. On another turn without noise the remaining "
    "error is 0.012″ RMS with all heads and 0.015″ to 0.020″ RMS with one missing head; the zeros",
    "of the sets agree within 0.001″ (`sim/tests/firmware/test_own_sets.py`). A test on the "
    "compiled instrument stops head 3, and the output stays correct "
    "(`sim/tests/instrument/test_failover.py`).",
    "",
)
"""Section about the calibration by the firmware; the firmware's tests measured its numbers."""
OBSERVABLE = (
    "## What three and four heads determine",
    "",
    "At each order a reading contains four unknowns: the motion of the table, the disc error, and "
    "the motion of the axis in two directions. One turn gives one equation per head;",
    "further turns with the same motion give no further equation. The tests of "
    "`sim/tests/calibration/test_observable_by_heads.py` show each row of the table for the heads "
    "of this page and for three heads at 0°, 118°, 237°.",
    "",
    "| Heads | Do the readings separate disc and axis? |",
    "|---|---|",
    "| four | Yes, at every order from 2 on, except where the gain of the places is infinite. At "
    "order 1 the forward circle of the axis gives the same readings as an eccentric disc; the mean "
    "contains neither |",
    "| three | No, at no order: for every disc error, some axis motion and table motion give the "
    "same three readings at every moment. The separation requires a further head, another position "
    "of the disc on the axis, or the knowledge that the axis is at rest at the order |",
    "| three, axis motion that does not repeat from turn to turn | Yes: the axis motion averages "
    "out |",
    "",
    "The mean of three heads contains no axis motion. But the calibration attributes axis motion "
    "to the disc, and the lanes then subtract it from the mean. With heads at 0°, 118°, 237°, 1″ "
    "of axis motion causes an output error of 0.02″ to 0.05″ at orders 2, 4 and 5, 10″ at order 3 "
    "and 5″ at order 6.",
    "Heads near 120° determine orders 3 and 6 poorly (noise gain 8.9 and 4.4), and their mean "
    "contains the full disc error of these orders. If the axis moves at these orders, set "
    "`gain_limit` below these gains or use a fourth head.",
    "",
)
"""Section about the errors that the heads determine, and the tests that prove it."""


def _at_most(found_arcsec: float, goal_arcsec: float) -> str:
    """Return a goal with its unit, marked if the found value misses it."""
    return f"≤ {goal_arcsec:g}″" + ("" if found_arcsec <= goal_arcsec else " (missed)")


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
            "The weighted mean of four heads at the places pᵢ, with Σwᵢ = 1 and Σwᵢ·e^{jpᵢ} = 0, "
            "does not change when the axis or the centre of the disc moves. This is true for",
            "motion of every order, and for motion that does not repeat. One combination of the "
            "four readings contains neither table motion nor axis motion: from it the calibration "
            "estimates",
            "the disc's error in the mean, and the lanes (circuits that each add one harmonic) "
            "correct this error. `arctrue heads` "
            "calibrates a simulated table once and evaluates this calibration on other turns, with",
            "the number formats of the gateware's mean. The command makes this page from "
            "[heads.json](data/heads.json).",
            "",
            "```sh",
            ".venv/bin/arctrue heads --page docs/heads.md --json docs/data/heads.json",
            "```",
            "",
            "| Setting | Value |",
            "|---|---|",
            f"| places of the four heads, measured from head 1 | {places} |",
            "| places of the two heads | 0°, 33° |",
            "| errors of the heads' places and of the index marks | up to ± 50″ |",
            "| disc | as in [`arctrue revolution`](instrument.md) |",
            f"| samples | {found['samples_a_turn']:,} per turn, noise of 0.1″ on each reading, "
            "counts of 0.077″ |",
            "| goals | fixed before the study |",
            "",
            "The results are from turns that the calibration did not use:",
            "",
            "| Case and result | Two heads | Four heads | Goal |",
            "|---|---:|---:|---:|",
            "| Ball pass of 0.25 µm and axis motion at orders 2 and 3, both also during the "
            f"calibration: attenuation of the ball pass | 1 | {balls['attenuation']:,.0f} | ≥ 500 "
            "|",
            f"| Same motion, rounding to counts, no noise: RMS error | "
            f"{balls['two_heads_without_noise_rms_arcsec']:.3f}″ | "
            f"{balls['mean_without_noise_rms_arcsec']:.3f}″ | |",
            "| Same motion, 0.1″ of noise: RMS error | "
            f"{balls['two_heads_rms_arcsec']:.3f}″ | {balls['mean_rms_arcsec']:.3f}″ | "
            f"{_at_most(balls['mean_rms_arcsec'], 0.06)} |",
            "| Same motion, 0.1″ of noise: RMS error of means over 20 samples | | "
            f"{balls['mean_of_20_rms_arcsec']:.3f}″ | |",
            "| Disc's centre moves by 2 µm after the calibration, equal head radii: RMS change of "
            f"the output | {equal['on_head1_rms_arcsec']:.2f}″ | "
            f"{equal['on_mean_rms_arcsec']:.4f}″ | "
            f"{_at_most(equal['on_mean_rms_arcsec'], 0.005)} |",
            "| Disc's centre moves by 2 µm after the calibration, head radii within ± 0.1 mm: RMS "
            f"change of the output | {unequal['on_head1_rms_arcsec']:.2f}″ | "
            f"{unequal['on_mean_rms_arcsec']:.4f}″ | "
            f"{_at_most(unequal['on_mean_rms_arcsec'], 0.01)} |",
            f"| Disc's error over orders 2 to {every['orders']}, {every['turns']} turns, heads at "
            f"{fine}, motion unknown at every order: 2σ of the estimate | – | "
            f"{every['left_2_sigma_arcsec']:.4f}″ ({every['expected_2_sigma_arcsec']:.4f}″ "
            f"expected from the gains) | {_at_most(every['left_2_sigma_arcsec'], 0.045)} |",
            "| Disc's error as in the row above, but axis known to be at rest: 2σ of the estimate "
            f"| – | {rest['left_2_sigma_arcsec']:.4f}″ ({rest['expected_2_sigma_arcsec']:.4f}″ "
            f"expected from the gains) | {_at_most(rest['left_2_sigma_arcsec'], 0.012)} |",
            "| A head moves by 100″ and the axis by 2 µm between two turns: error of the zero | – "
            f"| {wrong:.0f}″ until the calibration finds the head, then {zero:.3f}″ | "
            f"{_at_most(zero, 0.05)} |",
            "",
            *DEVICE,
            *OBSERVABLE,
            *FAULT_TABLE,
            "## One head missing",
            "",
            "One new turn is evaluated with five sets of weights: for all heads, and without each "
            "of the heads. The gateware stores all five sets. *Lanes* is the RMS of the",
            "disc's error in the weighted mean; this error differs between the sets, so that each "
            "set has its own lanes. *Zero* is the mean output minus the mean output with all "
            "heads.",
            "",
            "| Missing | Carrier | Weights | √Σwᵢ² | RMS error with 0.1″ of noise | RMS error "
            "without noise | Lanes | Zero |",
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
            "the offsets of all heads. Four heads give three differences. A motion of any of the",
            "four heads, together with a suitable axis motion, would explain the three "
            "differences; but only for the head that really moved, this axis motion is below 5 µm "
            "(`arctrue.calibration.moved_head`).",
            "If the firmware calibrates the mean itself, it does this test in every turn: it "
            "shifts the offset of the moved head and reports `moved_head` and `moved_arcsec` in "
            "the telemetry.",
            "",
            "| Moved by 100″ | Found | Found motion | Error of the mean's zero before the shift | "
            "after the shift |",
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
            "The table shows 2σ of the estimated disc's error over orders 2 to "
            f"{every['orders']}, for heads at {fine}, noise of 0.1″, whole counts and "
            f"{found['samples_a_turn']:,} samples per turn. It is calculated from the noise gain "
            "of every order, with known places and index marks.",
            "At these places the noise gains of all orders are low. Order 1 is omitted, because "
            "the mean does not contain it, and because the forward circle of the axis gives the "
            "same readings as an eccentric disc.",
            f"With {every['turns']} turns and heads at these places the study found "
            f"{every['known_places_2_sigma_arcsec']:.4f}″ (expected: "
            f"{every['expected_2_sigma_arcsec']:.4f}″) for unknown motion and "
            f"{rest['known_places_2_sigma_arcsec']:.4f}″ (expected: "
            f"{rest['expected_2_sigma_arcsec']:.4f}″) for the axis at rest. Places and marks that "
            f"are off by up to 50″ increase this to {every['left_2_sigma_arcsec']:.4f}″ and "
            f"{rest['left_2_sigma_arcsec']:.4f}″, which the table does not include. Each value is "
            "one draw with a standard deviation",
            "of 2 %. The published value of [time measurement on a free spin](methods.md) is "
            "0.006″.",
            "",
            "| Number of turns | " + " | ".join(every["by_turns"]) + " |",
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
            "The table shows the standard uncertainty of the mean from each cause alone.",
            "",
            "| Cause | u |",
            "|---|---:|",
            *(f"| {one['cause']} | {one['u_arcsec']:.4f}″ |" for one in budget),
            "",
            "The rounding of the output to whole counts causes more uncertainty than the rounding "
            "of the heads' readings. The calibration fits the heads' radii if the axis is known to "
            "make no backward",
            "circle of order 1; otherwise enter measured radii.",
            "",
        ]
    )
