"""Proofs of the conditions that multiply amplitudes (rtl/conditions)."""

from __future__ import annotations

from scripts.formal_proofs.proof import Break, Proof

STOP_OPERATOR = Proof(
    name="stop_operator",
    entity="stop_operator",
    claims=(
        "the place that gives the direction h stays between −width and width, for any motion "
        "and any change of width and dead zone",
        "once the place is known, it equals that of the stop operator, wherever this operator "
        "began",
    ),
    depth=3,
    cover_depth=16,
    probes={
        "probe_low": "stop.low",
        "probe_high": "stop.high",
        "probe_way": "stop.follow_way_5",
        "probe_to_top": "stop.follow_to_top_5",
        "probe_to_bottom": "stop.follow_to_bottom_5",
        "probe_width_before": "stop.follow_width_before",
        "probe_step": "stop.follow_step_3",
        "probe_slack": "stop.follow_slack",
        "probe_motion": "stop.follow_motion_4",
    },
    breaks=(
        Break(
            "the place goes beyond its upper end",
            "      to_top_5    := top - way_5;\n",
            "      to_top_5    := top;\n",
        ),
        Break(
            "the place goes one count beyond its lower end",
            "      to_bottom_5 := -top - way_5;\n",
            "      to_bottom_5 := -top - way_5 - 2 ** STOP_FRACTION;\n",
        ),
        Break(
            "a smaller width leaves the place where it was",
            "      if width /= width_before then\n",
            "      if width > width_before then\n",
        ),
        Break(
            "the place counts as known while both operators are one count apart",
            "      meets   <= '1' when low = high else '0';\n",
            "      meets   <= '1' when high - low <= 2 ** STOP_FRACTION else '0';\n",
        ),
        Break(
            "the dead zone is forgotten after a motion upwards",
            "        slack    := dead_zone;\n",
            "        slack    := (others => '0');\n",
        ),
        Break(
            "a large step downwards counts as motion",
            "      if step_2 > STOP_STEP_MAX or step_2 < -STOP_STEP_MAX then\n",
            "      if step_2 > STOP_STEP_MAX then\n",
        ),
    ),
)

TABLE_CONDITIONS = Proof(
    name="table_conditions",
    entity="table_conditions",
    claims=(
        "direction, speeds and words of the processor are between −1 and 1, for any place, "
        "travel and written word",
        "width, dead zone and nominal speed change together, at a swap, to the words whose "
        "writes are acknowledged",
        "`settled` is low from a write of these words until three sweeps have ended",
    ),
    limits="one bus access at a time; a swap holds the writes and waits for `settled`; the "
    "step of the sweep and the registers of the divider may have any value in any clock",
    depth=3,
    cover_depth=14,
    cut=("stop_operator*", "table_speed*"),
    cut_signals=(
        "table_conditions/w:step",
        *(f"unit_divider/w:divide_{name}" for name in ("rest", "against", "found", "left")),
    ),
    probes={
        **{
            f"probe_{signal}": f"conditions.{signal}"
            for signal in (
                *("width", "dead_zone", "nominal", "idle_width", "idle_dead_zone"),
                *("idle_nominal", "pending", "ratio", "speed_size", "idle_size"),
                *("target_a", "target_b", "real_direction", "divided"),
            )
        },
        "probe_ends": "conditions.settle_ends",
        "probe_fine_direction": "conditions.lead_direction.fine",
        "probe_fine_a": "conditions.lead_word_a.fine",
        "probe_fine_b": "conditions.lead_word_b.fine",
    },
    breaks=(
        Break(
            "a quotient above 1 is not limited",
            "          if found(STEPS) = '1' then\n",
            "          if found(STEPS) = '1' and found(STEPS - 1) = '1' then\n",
            entity="unit_divider",
        ),
        Break(
            "a word below −1 is not limited",
            "    elsif whole < -MODULATOR_ONE then\n",
            "    elsif whole < -2 * MODULATOR_ONE then\n",
        ),
        Break(
            "a word moves beyond its target",
            "        if is_beyond(way, slew) = '1' then\n",
            "        if is_beyond(way, slew and (slew'range => '0')) = '1' then\n",
            entity="slewed_word",
        ),
        Break(
            "the nominal speed stays at a swap",
            "        nominal   <= idle_nominal;\n",
            "",
        ),
        Break(
            "width and dead zone change before the swap",
            "      if swap_comes = '1' then\n        width ",
            "      if hold_writes = '1' then\n        width ",
        ),
        Break(
            "a word is written while a swap waits",
            "  write_now <= pending and not hold_writes and not reset;\n",
            "  write_now <= pending and not reset;\n",
        ),
        Break(
            "a swap does not wait for the sweep that multiplies the amplitudes",
            "      settled <= '1' when ends = 3 else '0';\n",
            "      settled <= '1' when ends >= 2 else '0';\n",
        ),
    ),
)
