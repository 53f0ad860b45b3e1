"""Ways to break the VHDL, and the test that must notice each; see scripts/mutate.py.

``old`` stands exactly once in ``file``. A mutation is worth its place when it is a slip that a
person could make and that another test would not show at once.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True)
class Mutation:
    """One wrong text in one file, and the pytest test that fails because of it."""

    name: str
    fault: str
    file: str
    old: str
    new: str
    test: str


VHDL_MUTATIONS: Final[tuple[Mutation, ...]] = (
    Mutation(
        "index_before_step",
        "the index passed downwards is latched behind the step instead of before it",
        "rtl/decoder/quadrature_decoder.vhd",
        "(position'range => meets_up and meets_inside), not meets_up);",
        "(position'range => meets_up and meets_inside), '0');",
        "tb/decoder/test_quadrature_decoder.py",
    ),
    Mutation(
        "index_by_the_last_step",
        "the direction of an index is that of the step before it, not of the step it belongs to",
        "rtl/decoder/quadrature_decoder.vhd",
        "          settled_level := before(0);\n",
        "          settled_level := filtered(0);\n",
        "tb/decoder/test_quadrature_decoder.py",
    ),
    Mutation(
        "index_reversal_within_a_count",
        "a change of Z within a count is taken for one beside the next step",
        "rtl/decoder/quadrature_decoder.vhd",
        "        if (since_settled > INDEX_SKEW) then\n",
        "        if (since_settled = 0) then\n",
        "tb/decoder/test_quadrature_decoder.py",
    ),
    Mutation(
        "turn_of_2_to_24",
        "the angle counts modulo 2**24 whatever counts_per_rev says",
        "rtl/decoder/quadrature_decoder.vhd",
        "last_angle := resize(counts_per_rev - 1, ANGLE_WIDTH);",
        "last_angle := (others => '1');",
        "tb/decoder/test_quadrature_decoder.py",
    ),
    Mutation(
        "index_tolerance_downwards",
        "an index too early is off by one more than one too late",
        "rtl/decoder/tolerance_pkg.vhd",
        "return (not low) ?< tolerance;",
        "return (not low) ?<= tolerance;",
        "tb/decoder/test_quadrature_decoder.py",
    ),
    Mutation(
        "zero_of_one_mark",
        "a single mark in the wrong place moves the zero",
        "rtl/decoder/quadrature_decoder.vhd",
        "(((are_within(1) or are_within(0)) and is_in_doubt) or",
        "(is_in_doubt or",
        "tb/decoder/test_quadrature_decoder.py",
    ),
    Mutation(
        "silent_overspeed",
        "edges that the filter swallows are not told",
        "rtl/decoder/quadrature_decoder.vhd",
        "      too_fast  := too_near or edges_lost;",
        "      too_fast  := too_near;",
        "tb/decoder/test_quadrature_decoder.py",
    ),
    Mutation(
        "illegal_counts",
        "A and B changing together count as a step",
        "rtl/decoder/quadrature_decoder.vhd",
        "moves        := (a_changes xor b_changes) and not preload;",
        "moves        := (a_changes or b_changes) and not preload;",
        "tb/decoder/test_quadrature_decoder.py",
    ),
    Mutation(
        "filter_one_longer",
        "the glitch filter asks for one sample more",
        "rtl/decoder/glitch_filter.vhd",
        "lasted(i) >= filter_length",
        "lasted(i) > filter_length",
        "tb/decoder/test_glitch_filter.py",
    ),
    Mutation(
        "phase_cut_off",
        "the phase is cut off instead of rounded",
        "rtl/phase/phase_lane.vhd",
        "(phase_offset & HALF) + low_product_2;",
        "(phase_offset & (HALF'range => '0')) + low_product_2;",
        "tb/phase/test_phase_lane.py",
    ),
    Mutation(
        "sign_of_the_paper",
        "y turns the wrong way, as equation (10) is printed",
        "rtl/harmonic/cordic_rotation.vhd",
        "shift_right(x(i) & '0', i), not left)",
        "shift_right(x(i) & '0', i), left)",
        "tb/harmonic/test_cordic_rotation.py",
    ),
    Mutation(
        "wrong_quadrant",
        "the cosine is negative in the wrong half of the turn",
        "rtl/harmonic/quadrant_fold.vhd",
        "negative <= phase(PHASE_WIDTH - 1) xor phase(PHASE_WIDTH - 2);",
        "negative <= phase(PHASE_WIDTH - 1);",
        "tb/harmonic/test_harmonic_lane.py",
    ),
    Mutation(
        "capture_before_ready",
        "the capture window answers without a ready bank",
        "rtl/registers/access_guard.vhd",
        "and is_write = '0' and capture_ready = '1' and sample <= CAPTURE_DEPTH - 1;",
        "and is_write = '0' and sample <= CAPTURE_DEPTH - 1;",
        "tb/registers/test_arctrue_registers.py::test_register_block",
    ),
    Mutation(
        "turn_without_fold",
        "a corrected angle below zero is not folded into the turn",
        "rtl/compensation/error_compensation.vhd",
        "if straight(TURN_WIDTH - 1) = '1' then",
        "if straight(TURN_WIDTH - 1) = 'U' then",
        "tb/compensation/test_error_compensation.py",
    ),
    Mutation(
        "truncated_correction",
        "the total is cut off instead of rounded",
        "rtl/compensation/error_compensation.vhd",
        "round_up  := not total(PAIR_FRACTION - 1);",
        "round_up  := '1';",
        "tb/compensation/test_error_compensation.py",
    ),
    Mutation(
        "late_position",
        "the reading is one clock older than its correction",
        "rtl/compensation/delay_line.vhd",
        "delayed <= stages(CLOCKS);",
        "delayed <= stages(CLOCKS - 1);",
        "tb/compensation/test_delay_line.py",
    ),
    Mutation(
        "folded_bank_cut_in_two",
        "a swap takes effect while an angle is still meeting its lanes",
        "rtl/coefficients/coefficient_memory.vhd",
        "swap_now  <= (swap or swap_waits) and swap_allowed;",
        "swap_now  <= swap;",
        "tb/core/test_compensation_pipeline.py::test_folded_swaps_are_atomic",
    ),
    Mutation(
        "folded_lanes_out_of_step",
        "the amplitudes of a folded lane come one slot late",
        "rtl/core/compensation_pipeline.vhd",
        "CLOCKS => PHASE_LATENCY + AMPLITUDE_CLOCK\n",
        "CLOCKS => PHASE_LATENCY + AMPLITUDE_CLOCK + 1\n",
        "tb/core/test_compensation_pipeline.py::test_folds_give_the_same_corrections",
    ),
    Mutation(
        "folded_sum_of_two_angles",
        "the sums of an angle are added to those of the one before it",
        "rtl/compensation/error_compensation.vhd",
        "      if first_sums = '1' then\n",
        "      if first_sums = 'U' then\n",
        "tb/compensation/test_error_compensation.py::test_folded_sums",
    ),
    Mutation(
        "ramp_past_zero",
        "the remainder swings through zero instead of ending there",
        "rtl/compensation/correction_ramp.vhd",
        "(stops_at_zero = '1' and decayed(WIDTH - 1) = falling)",
        "stops_at_zero = 'U'",
        "tb/compensation/test_correction_ramp.py",
    ),
    Mutation(
        "step_at_swap",
        "the difference to the correction before is not caught",
        "rtl/compensation/correction_ramp.vhd",
        "excess := unramped - held - jump;",
        "excess := (others => '0');",
        "tb/compensation/test_correction_ramp.py",
    ),
    Mutation(
        "mixed_banks",
        "phases of the new bank meet phase steps of the old one",
        "rtl/coefficients/coefficient_memory.vhd",
        "if copying(PHASE_OFFSET_DELAY) = '1' then",
        "if swap_now = '1' then",
        "tb/coefficients/test_coefficient_memory.py",
    ),
    Mutation(
        "write_during_copy",
        "a write reaches the idle bank while it is being copied",
        "rtl/coefficients/coefficient_memory.vhd",
        "and not swap and not (or copying) and not reset;",
        "and not reset;",
        "tb/coefficients/test_coefficient_memory.py",
    ),
    Mutation(
        "bank_taken_back",
        "a bank of the processor counts as free when the other is full",
        "rtl/sampler/sampler.vhd",
        "if owned = '1' then",
        "if owned = 'U' then",
        "tb/sampler/test_sampler.py",
    ),
    Mutation(
        "heads_of_two_clocks",
        "head 2 is latched one clock after head 1",
        "rtl/sampler/sampler.vhd",
        "std_ulogic_vector(position2_then) & std_ulogic_vector(position1_then);",
        "std_ulogic_vector(turn_position2) & std_ulogic_vector(position1_then);",
        "tb/sampler/test_sampler.py",
    ),
    Mutation(
        "turn_one_way",
        "a turn closes only when the table turns up",
        "rtl/sampler/sampler.vhd",
        "(is_above_then = '1' or is_below_then = '1')",
        "is_above_then = '1'",
        "tb/sampler/test_sampler.py",
    ),
    Mutation(
        "no_hysteresis",
        "a position that trembles by one count makes edges",
        "rtl/quadrature_output/quadrature_output.vhd",
        "step_up   := remaining(2) or (remaining(1) and one_up);",
        "step_up   := remaining(1);",
        "tb/quadrature_output/test_quadrature_output.py",
    ),
    Mutation(
        "z_after_one_turn",
        "Z is not found again behind the end of the turn",
        "rtl/quadrature_output/quadrature_output.vhd",
        "angles_ahead(-1)  := angle_ahead - signed('0' & counts_per_rev);",
        "angles_ahead(-1)  := angle_ahead;",
        "tb/quadrature_output/test_quadrature_output.py",
    ),
    Mutation(
        "z_without_reference",
        "Z comes before the first index and in a re-arm",
        "rtl/quadrature_output/quadrature_output.vhd",
        "z_level := referenced_then(2);",
        "z_level := '1';",
        "tb/quadrature_output/test_quadrature_output.py",
    ),
    Mutation(
        "replays_a_backlog",
        "the output sends after a standstill what came too fast",
        "rtl/quadrature_output/quadrature_output.vhd",
        "following := enable and not cannot_keep_up;",
        "following := enable;",
        "tb/quadrature_output/test_quadrature_output.py",
    ),
    Mutation(
        "phase_of_the_power_up",
        "the zero lies in another state of A and B after each power-up",
        "rtl/quadrature_output/quadrature_output.vhd",
        "output   := corrected_position + signed(to_phase);",
        "output   := corrected_position;",
        "tb/quadrature_output/test_quadrature_output.py",
    ),
    Mutation(
        "burst_at_a_shorter_turn",
        "the output follows the correction as a shorter turn clips it",
        "rtl/core/arctrue_core.vhd",
        "follow <= hwif_out.control.output_enable.value and not changes_turn;",
        "follow <= hwif_out.control.output_enable.value;",
        "tb/core/test_arctrue_core.py::test_core",
    ),
    Mutation(
        "reference_before_its_angle",
        "the index is told a clock before the angle that counts from it",
        "rtl/compensation/error_compensation.vhd",
        "corrected_referenced <= referenced_1_to_3(3);",
        "corrected_referenced <= referenced_1_to_3(2);",
        "tb/core/test_compensation_pipeline.py::test_latencies",
    ),
    Mutation(
        "address_taken_in_reset",
        "a write that begins during the fabric's reset is lost, and the processor waits for ever",
        "rtl/top/axi3_to_axi_lite.vhd",
        "'1' when writing = WRITE_IDLE and reset = '0' else",
        "'1' when writing = WRITE_IDLE else",
        "tb/top/test_arctrue_zynq_top.py",
    ),
    Mutation(
        "interrupt_line",
        "the interrupt goes to the line beside its own",
        "rtl/top/zynq_processor.vhd",
        "(0 => interrupt, others => '0')",
        "(1 => interrupt, others => '0')",
        "tb/top/test_arctrue_zynq_top.py",
    ),
    Mutation(
        "led_forgets",
        "an event within a window is not shown by its LED",
        "rtl/top/status_leds.vhd",
        "shown <= seen or now;",
        "shown <= now;",
        "tb/top/test_status_leds.py",
    ),
)
