"""Proof of the limits of the ramp (rtl/compensation)."""

from __future__ import annotations

from scripts.formal_proofs.proof import Break, Proof

_RAMP_SIGNALS = {
    "ramp": (
        *("excess", "next_excess", "marker_then", "is_at_rest", "stops_at_zero", "step"),
        *("step_rises", "falling", "ends", "moves"),
    ),
    "ramp.motion": ("velocity", "is_at_once"),
}

_DECISION_VARIABLES = (
    *("tick", "moment", "way", "way_straight", "way_faster", "way_same", "way_less"),
    *("size", "faster", "slower", "is_faster_too_fast", "is_too_fast", "is_stale"),
    *("is_zero", "goes_away", "is_last", "is_slow", "brakes", "stops", "speeds", "is_end"),
    *("is_short_of_faster", "is_short_of_same"),
    *("takes_off", "of_margin", "of_same", "of_way_back"),
)

CORRECTION_RAMP = Proof(
    name="correction_ramp",
    entity="correction_ramp",
    claims=(
        "the velocity of the remainder r never rises above `ramp_rate`, and falls in every tick "
        "while it is above a lower rate; it changes once in a tick, by the acceleration, and "
        "reaches 0 from at most the acceleration, or from less than 2 units per tick where r is 0",
        "r moves by the velocity in each clock, and no fraction of a unit is lost; at the end r "
        "jumps to 0 from at most 1.5 times the distance of the first tick, or from one unit",
        "after a marker that comes while r stands, r decays from its latched value to 0 and passes "
        "0 by at most one unit; with acceleration 0 it does not pass 0. After any marker it passes "
        "0 by at most one unit from the first tick on in which it need not brake",
        "r arrives: in each tick without a marker r decreases, or the velocity rises, or the ramp "
        "ends, unless the rate is less than a step and a unit per tick; from the end on, r is 0 "
        "until the next marker",
    ),
    limits="the rate is 0 to 3 units per tick and may change in any clock; the acceleration is "
    "0 to 15 quarters of a unit per tick and constant; the total is left to the benches",
    constants={
        "PAIR_FRACTION": 10,
        "RAMP_TICK_WIDTH": 4,
        "RAMP_VELOCITY_FRACTION": 2,
        "RAMP_MARGIN_BITS": 1,
        "RAMP_LOOK_CLOCK": 9,
    },
    depth=1,
    cover_depth=22,
    probes={
        **{
            f"probe_{signal}": f"{part}.{signal}"
            for part, signals in _RAMP_SIGNALS.items()
            for signal in signals
        },
        **{f"probe_{name}": f"ramp.motion.choose_velocity_{name}" for name in _DECISION_VARIABLES},
        "probe_fraction": "ramp.motion.hand_out_fraction",
        "probe_was_marker": "ramp.motion.hand_out_was_marker",
    },
    breaks=(
        Break(
            "the velocity rises above the rate",
            "          is_faster_too_fast := is_above_limit;\n",
            "          is_faster_too_fast := '0';\n",
            entity="ramp_velocity",
        ),
        Break(
            "the velocity does not follow a rate that becomes lower",
            "          is_too_fast := is_above_limit;\n",
            "          is_too_fast := '0';\n",
            entity="ramp_velocity",
            skip=19,
        ),
        Break(
            "the velocity changes by two steps",
            "            velocity <= faster(velocity'range);\n",
            "            velocity <= faster(velocity'high - 1 downto 0) & '0';\n",
            entity="ramp_velocity",
            skip=17,
        ),
        Break(
            "the fraction of a unit is lost",
            "      fraction := sum(fraction'range);\n",
            "      fraction := (others => '0');\n",
            entity="ramp_velocity",
        ),
        Break(
            "a step downwards is one unit too long",
            "      step_rises <= not falling;\n",
            "      step_rises <= '1';\n",
            entity="ramp_velocity",
        ),
        Break(
            "with acceleration 0 an excess that rises passes 0",
            "(next_excess(WIDTH - 1) xnor falling)",
            "(next_excess(WIDTH - 1) and falling)",
        ),
        Break(
            "the remainder is latched without the total",
            "        next_excess <= resize(correction, WIDTH) - held;\n",
            "        next_excess <= resize(correction, WIDTH);\n",
        ),
    ),
)
