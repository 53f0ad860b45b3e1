"""Makes the page of ``arctrue heads`` from its result."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any


def _fault_table(found: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the section about the faults of a head."""
    one, count_arcsec = found["failover"], found["settings"]["count_arcsec"]
    weight = max(found["missing"][0]["weights"])
    step, missing = one["step_counts"], one["missing_counts"]
    lanes, heads = one["lanes"], one["heads"]
    load, reaction = _time(one["load_s"], 1), _time(one["reaction_s"])
    fast, slow = (f"{one[name]:g}°/s" for name in ("speed_deg_s", "slow_deg_s"))
    motion, eccentricity = (
        f"{one[name] * 1e6:g} µm" for name in ("axis_motion_m", "eccentricity_m")
    )
    small = 2 * step

    def error(counts: float, digits: int = 1) -> str:
        return f"{weight * counts * count_arcsec:.{digits}f}″"

    return (
        "## A head that fails",
        "",
        "With the generic `FAILOVER` the gateware removes a failed head from the mean: it loads "
        "the "
        "set that was prepared for the other heads, and swaps to this set; a ramp limits the "
        "output's",
        "change ([head_failover](entities/head_failover.md)). A set contains carrier (the head "
        "whose reading the output follows), weights, offsets and lanes. One block RAM holds all "
        "sets of "
        f"four heads and {lanes} lanes; loading one set takes",
        f"{heads} · (4 · {lanes} + 10) + 4 clocks, {load} at {one['clock_hz'] / 1e6:g} MHz. The "
        "benches in the table are cocotb tests of "
        "`tb/core/failover_core_bench.py`, with four lanes and a short turn. They show",
        "that the output steps by at most 2 counts in a clock, one count of motion and one "
        "count of "
        "rounding, and that after the swap the mean of the three other heads is correct.",
        f"The figures are for 2²⁴ counts of {count_arcsec:.3f}″; w is the weight of the failed "
        "head, at "
        f"most {weight:.2f} at these places.",
        "",
        "| Fault of a head | Detected by | Time until the swap | Output error until the swap | "
        "Bench |",
        "|---|---|---|---|---|",
        f"| illegal step | the head's decoder | {one['detected_clocks']} clocks and {load}: "
        f"{reaction} | w · 2 counts: {error(2, 2)} | "
        "`an_illegal_step_leaves_a_head_out` |",
        "| signals are too fast | the head's decoder | "
        f"{one['detected_clocks']} clocks and {load}: {reaction} | w · 1 count per clock | "
        "`a_head_that_is_too_fast_is_left_out` |",
        "| the glitch filter suppresses counts | the head's decoder | "
        f"{one['detected_clocks']} clocks and {load} after 4 suppressed counts | "
        "w · (4 counts and 1 count per clock) | "
        "`a_head_whose_counts_the_filter_suppresses_is_left_out` |",
        "| signals are dead or stuck: the count stands while all other heads move | "
        "`missing_edges`, "
        f"{missing} counts | {missing} counts and {load}: {_time(one['missing_s'])} at {fast}, "
        f"{_time(one['missing_slow_s'])} at {slow}; never at standstill | w · "
        f"{one['missing_until_swap_counts']} counts: {error(one['missing_until_swap_counts'])} "
        f"at {fast} | `a_dead_carrier_is_left_out` |",
        f"| slip of {small} counts or more within {one['watched_least_s'] * 1e3:.2f} ms | "
        "comparison with all other heads: `step_limit`, "
        f"{step} counts | {one['detected_clocks']} clocks and {load} after the first {small} "
        f"counts | w · ({small} counts and the counts "
        f"that slip in {reaction}), at most w · slip: {error(one['slip_until_swap_counts'])} for "
        f"{one['slip_counts']:,} counts at {one['slip_clocks_a_count']} clocks per count | "
        "`a_head_that_steps_against_the_others_is_left_out` (80 counts); "
        f"`sim/tests/instrument/test_failover.py` ({one['slip_counts']:,} counts, which may also "
        "appear as illegal "
        "steps) |",
        f"| slip of less than {small} counts | the head's index; or the parity exceeds its limit "
        "(alarm "
        f"only) | one turn | w · {small - 1} counts: {error(small - 1)} | "
        "`a_small_slip_is_found_at_the_index`, "
        "`the_parity_shows_a_slip_at_once` |",
        "| slip of at most `index_tolerance` | not detected | – | w · tolerance | "
        "`no_head_fails_without_a_fault` |",
        "| one fault hits several heads, for example because the table is too fast | the heads' "
        f"decoders | {reaction}; the gateware removes only the first head; if several fail in "
        "one clock, "
        "the one with the lowest number | the counts that the other heads lost, until their "
        "indices | "
        "`a_fault_of_all_heads_leaves_one_out` |",
        "| a second head fails | the head's decoder (alarm only); the prepared sets omit only "
        "one head "
        "| – | not bounded | `tb/mean/head_failover_bench.py` |",
        "| no fault: a head returns after its index | – | on request or after a set time | none | "
        "`a_head_comes_back_after_its_index`, `a_return_obeys_the_limits_of_the_ramp` |",
        "| no fault: the firmware swaps or loads words that use the failed head | the gateware "
        "refuses "
        "these words | – | none | `a_swap_does_not_bring_a_dead_head_back`, "
        "`a_set_that_uses_the_failed_head_is_not_taken` |",
        "",
        "Formal [proofs](proofs.md) show for every sequence of inputs: A and B of the output never "
        "change together, for any requested angle and position, so that no swap of a set",
        "causes an illegal step; lanes, weights and offsets of a set are swapped together; a "
        "removed "
        "head has the weight 0 and returns only after its index.",
        "",
        "The gateware distinguishes a step of a head from axis motion without the places of the "
        "heads: "
        "it removes head k if the readings of all other heads changed equally, within the limit,",
        f"and if head k is the only head for which this is true. Axis motion of {motion} changes "
        "the "
        f"difference of two heads on a radius of {one['radius_m'] * 1e3:g} mm by up to "
        f"{one['axis_counts']:.1f} counts at 2²⁴ counts per turn "
        f"(on a radius r: {one['axis_counts_mm']:.0f} counts · mm / r). An eccentricity of "
        f"{eccentricity} adds up to {one['swing_counts']:.1f} counts",
        f"in {one['watched_s'] * 1e3:.2f} ms at {fast}. Under these conditions, with a limit of "
        f"{step} counts, the gateware never "
        f"removes a wrong head and always detects a slip of 2 · {step} counts or more;",
        f"whether it detects a slip of {step} to {small} counts depends on the motion. Faster "
        "tables, larger "
        f"motions and smaller discs need a larger `failover_step_counts`: {small} for r = "
        f"{one['small_radius_m'] * 1e3:.0f} mm, where the "
        f"axis motion causes {one['small_axis_counts']:.1f} and the eccentricity "
        f"{one['small_swing_counts']:.1f} counts.",
        "",
        "A removed head returns to the mean on request (console command `come_back`) or after "
        "the time "
        "`failover.return_after`, as soon as it has seen its next index. The ramp spreads the",
        "change; the index repeats within ± 1 count. A dead head sees no index and does not "
        "return. "
        "A snapshot contains the parity Σcᵢ·rᵢ of the readings rᵢ, which neither table motion nor",
        "axis motion changes; this parity exists for four heads only. The device computes the "
        "prepared sets itself, or `arctrue load` loads them "
        "([firmware](firmware-load.md#three-and-four-heads)).",
        "",
    )


DEVICE = (
    "## Calibrated by the device",
    "",
    "If the places of all heads are known, the [firmware](firmware.md#three-and-four-heads) "
    "calibrates the mean of three or four heads from captured turns and corrects this mean.",
    "A test calibrates with the firmware's C code and a bit-true model of the gateware's mean on "
    "one turn at the paper's conditions (2²⁴ counts, 12,000 samples, 0.2″ of noise",
    "on each reading; heads 50″, 30″ and 40″ off their places; index marks that repeat exactly) "
    "and evaluates another turn. In each of five draws the remaining error, averaged",
    "over half a degree, stays within the goal of ± 0.07″ and 0.022″ RMS "
    "(`pytest sim/tests/firmware/test_heads.py -k papers_conditions`).",
    "`arctrue revolution --heads 4` sends every edge through the compiled gateware: at full size "
    "−0.046″ to +0.047″ and 0.016″ RMS remain (8 minutes); with `--lines 4096` ±0.059″ and 0.018″ "
    "RMS.",
    "",
    "With four heads and the generic `FAILOVER` the device also computes, at every swap, the sets "
    "for one missing head, and then switches the failover on. A test calibrates on one turn of",
    "6,000 samples with 0.1″ of noise and axis motion. On another turn without noise, less than "
    "0.04″ RMS remains with all heads and with one missing head; the zeros of the sets",
    "agree within 0.01″ (`pytest sim/tests/firmware/test_own_sets.py -k another_turn`). A test "
    "on the "
    "compiled instrument stops head 3, and the output stays correct "
    "(`sim/tests/instrument/test_failover.py`).",
    "",
)
"""Section about the calibration by the firmware; the commands in it show its figures."""


def _observable(found: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the section about the errors that the heads determine, and the tests that prove it."""
    three = found["three_heads"]
    places = ", ".join(f"{place:g}°" for place in three["places_deg"])
    share, gain = three["share_by_order"], three["gain_by_order"]
    strong = [value for order, value in share.items() if order not in gain]
    orders = [order for order in share if order not in gain]
    return (
        "## What three and four heads determine",
        "",
        "At each order a reading contains four unknowns: the motion of the table, the disc "
        "error, and "
        "the motion of the axis in two directions. One turn gives one equation per head;",
        "further turns with the same motion give no further equation. The tests of "
        "`sim/tests/calibration/test_observable_by_heads.py` show each row of the table for the "
        "heads "
        f"of this page and for three heads at {places}.",
        "",
        "| Heads | Do the readings separate disc and axis? |",
        "|---|---|",
        "| four | Yes, at every order from 2 on, except where the gain of the places is "
        "infinite. At "
        "order 1 the forward circle of the axis gives the same readings as an eccentric disc; "
        "the mean "
        "contains neither |",
        "| three | No, at no order: for every disc error, some axis motion and table motion "
        "give the "
        "same three readings at every moment. The separation requires a further head, another "
        "position "
        "of the disc on the axis, or the knowledge that the axis is at rest at the order |",
        "| three, axis motion that does not repeat from turn to turn | Yes: the axis motion "
        "averages "
        "out |",
        "",
        "The mean of three heads contains no axis motion. But the calibration attributes axis "
        "motion "
        f"to the disc, and the lanes then subtract it from the mean. With heads at {places}, "
        f"{three['motion_arcsec']:g}″ "
        f"of axis motion along x causes an output error of {min(strong):.2f}″ to "
        f"{max(strong):.2f}″ at orders {_and(orders)}, "
        f"{_and([f'{share[order]:.0f}″ at order {order}' for order in gain])}.",
        f"Heads near 120° determine orders {_and(list(gain))} poorly (noise gain "
        f"{_and([f'{one:.1f}' for one in gain.values()])}), and their mean "
        "contains the full disc error of these orders. If the axis moves at these orders, set "
        "`gain_limit` below these gains or use a fourth head.",
        "",
    )


def _and(words: list[str]) -> str:
    return ", ".join(words[:-1]) + " and " + words[-1]


def _time(seconds: float, digits: int = 0) -> str:
    """Return a time in microseconds or milliseconds."""
    if seconds < 1e-3:
        return f"{seconds * 1e6:.{digits}f} µs"
    return f"{seconds * 1e3:.{digits}f} ms"


def _arcsec(value: float) -> str:
    """Return four decimals; a smaller value as a limit."""
    return f"{value:.4f}″" if value >= 1e-4 else "< 0.0001″"


def _at_most(found_arcsec: float, goal_arcsec: float) -> str:
    """Return a goal with its unit, marked if the found value misses it."""
    return f"≤ {goal_arcsec:g}″" + ("" if found_arcsec <= goal_arcsec else " (missed)")


def heads_page(found: Mapping[str, Any]) -> str:
    """Return the page as Markdown."""
    balls, budget = found["ball_pass"], found["budget"]
    settings, goals = found["settings"], found["goals"]
    noise = f"{settings['noise_arcsec']:g}″"
    ball, shift, limit = (
        f"{settings[name] * 1e6:g} µm" for name in ("ball_pass_m", "shift_m", "axis_limit_m")
    )
    radii = f"± {settings['radius_tolerance_m'] * 1e3:g} mm"
    mounting, moved = (f"{settings[name]:g}″" for name in ("mounting_arcsec", "moved_arcsec"))
    two = ", ".join(f"{place:g}°" for place in settings["two_places_deg"])
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
            "does not change to first order when the axis or the centre of the disc moves. This "
            "is true for",
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
            f"| places of the two heads | {two} |",
            f"| errors of the heads' places and of the index marks | up to ± {mounting} |",
            "| disc | as in [`arctrue revolution`](instrument.md) |",
            f"| samples | {found['samples_a_turn']:,} per turn, noise of {noise} on each reading, "
            f"counts of {settings['count_arcsec']:.3f}″ |",
            "| goals | fixed before the study |",
            "",
            "The results are from turns that the calibration did not use:",
            "",
            "| Case and result | Two heads | Four heads | Goal |",
            "|---|---:|---:|---:|",
            f"| Ball pass of {ball} and axis motion at orders 2 and 3, both also during the "
            f"calibration: attenuation of the ball pass | 1 | {balls['attenuation']:,.0f} | "
            f"≥ {goals['attenuation']:g} |",
            f"| Same motion, rounding to counts, no noise: RMS error | "
            f"{balls['two_heads_without_noise_rms_arcsec']:.3f}″ | "
            f"{balls['mean_without_noise_rms_arcsec']:.3f}″ | |",
            f"| Same motion, {noise} of noise: RMS error | "
            f"{balls['two_heads_rms_arcsec']:.3f}″ | {balls['mean_rms_arcsec']:.3f}″ | "
            f"{_at_most(balls['mean_rms_arcsec'], goals['mean_arcsec'])} |",
            f"| Same motion, {noise} of noise: RMS error of means over "
            f"{settings['averaged_samples']} samples | | "
            f"{balls['mean_of_20_rms_arcsec']:.3f}″ | |",
            f"| Disc's centre moves by {shift} after the calibration, equal head radii: RMS "
            "change of "
            f"the output | {equal['on_head1_rms_arcsec']:.2f}″ | "
            f"{equal['on_mean_rms_arcsec']:.4f}″ | "
            f"{_at_most(equal['on_mean_rms_arcsec'], goals['equal_radii_arcsec'])} |",
            f"| Disc's centre moves by {shift} after the calibration, head radii within {radii}: "
            "RMS "
            f"change of the output | {unequal['on_head1_rms_arcsec']:.2f}″ | "
            f"{unequal['on_mean_rms_arcsec']:.4f}″ | "
            f"{_at_most(unequal['on_mean_rms_arcsec'], goals['unequal_radii_arcsec'])} |",
            f"| Disc's error over orders 2 to {every['orders']}, {every['turns']} turns, heads at "
            f"{fine}, motion unknown at every order: 2σ of the estimate | – | "
            f"{every['left_2_sigma_arcsec']:.4f}″ ({every['expected_2_sigma_arcsec']:.4f}″ "
            "expected from the gains) | "
            f"{_at_most(every['left_2_sigma_arcsec'], goals['motion_unknown_arcsec'])} |",
            "| Disc's error as in the row above, but axis known to be at rest: 2σ of the estimate "
            f"| – | {rest['left_2_sigma_arcsec']:.4f}″ ({rest['expected_2_sigma_arcsec']:.4f}″ "
            "expected from the gains) | "
            f"{_at_most(rest['left_2_sigma_arcsec'], goals['axis_at_rest_arcsec'])} |",
            f"| A head moves by {moved} and the axis by {shift} between two turns: error of the "
            "zero | – "
            f"| {wrong:.0f}″ until the calibration finds the head, then {zero:.3f}″ | "
            f"{_at_most(zero, goals['zero_arcsec'])} |",
            "",
            *DEVICE,
            *_observable(found),
            *_fault_table(found),
            "## One head missing",
            "",
            "One new turn is evaluated with five sets of weights: for all heads, and without each "
            "of the heads. The gateware stores all five sets. *Lanes* is the RMS of the",
            "disc's error in the weighted mean; this error differs between the sets, so that each "
            "set has its own lanes. *Zero* is the mean output minus the mean output with all "
            "heads.",
            "",
            f"| Missing | Carrier | Weights | √Σwᵢ² | RMS error with {noise} of noise | RMS error "
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
            "differences. In the table only the explanation by the head that really moved has an "
            f"axis motion below {limit} (`arctrue.calibration.moved_head`). If several heads fit, "
            "for example after a smaller motion, the calibration reports no moved head.",
            "If the firmware calibrates the mean itself, it does this test in every turn: it "
            "shifts the offset of the moved head and reports `moved_head` and `moved_arcsec` in "
            "the telemetry.",
            "",
            f"| Moved by {moved} | Found | Found motion | Error of the mean's zero before the "
            "shift | "
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
            f"{every['orders']}, for heads at {fine}, noise of {noise}, whole counts and "
            f"{found['samples_a_turn']:,} samples per turn. It is calculated from the noise gain "
            "of every order, with known places and index marks.",
            f"At these places the noise gain of every order is at most {every['largest_gain']:.1f} "
            f"(motion unknown) and {rest['largest_gain']:.1f} (axis at rest). Order 1 is "
            "omitted, because "
            "the mean does not contain it, and because the forward circle of the axis gives the "
            "same readings as an eccentric disc.",
            f"With {every['turns']} turns and heads at these places the study found "
            f"{every['known_places_2_sigma_arcsec']:.4f}″ (expected: "
            f"{every['expected_2_sigma_arcsec']:.4f}″) for unknown motion and "
            f"{rest['known_places_2_sigma_arcsec']:.4f}″ (expected: "
            f"{rest['expected_2_sigma_arcsec']:.4f}″) for the axis at rest. Places and marks that "
            f"are off by up to {mounting} increase this to {every['left_2_sigma_arcsec']:.4f}″ and "
            f"{rest['left_2_sigma_arcsec']:.4f}″, which the table does not include. Each value is "
            "one draw; because the gains differ, its relative standard deviation is",
            f"{100.0 * every['relative_scatter']:.0f} % (motion unknown) and "
            f"{100.0 * rest['relative_scatter']:.0f} % (axis at rest). The published value of "
            "[time measurement on a free "
            "spin](methods.md) "
            f"is {settings['time_measurement_arcsec']:g}″.",
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
            "The table shows the standard uncertainty of the mean from each cause alone, with "
            "equal "
            "errors of all heads that do not depend on each other. A Monte Carlo with another "
            "program gives the same values within 3 % (`pytest "
            "sim/tests/studies/heads/test_budget.py`).",
            "",
            "| Cause | u |",
            "|---|---:|",
            *(f"| {one['cause']} | {_arcsec(one['u_arcsec'])} |" for one in budget),
            "",
            "The rounding of the output to whole counts causes more uncertainty than the rounding "
            "of the heads' readings. The calibration fits the heads' radii if the axis is known to "
            "make no backward",
            "circle of order 1; otherwise enter measured radii.",
            "",
        ]
    )
