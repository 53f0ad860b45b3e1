"""Proof of the count of turns (rtl/phase)."""

from __future__ import annotations

from scripts.formal_proofs.proof import Break, Proof

TURN_COUNTER = Proof(
    name="turn_counter",
    entity="turn_counter",
    claims=(
        "from one accepted angle to the next, turn number and angle together change by the "
        "shorter way from the old angle to the new angle, also if the angle wraps",
        "`turn_select` of an angle is its turn number modulo 4, one clock later",
    ),
    limits="angles are below counts_per_rev, which is constant",
    depth=3,
    constants={"ANGLE_WIDTH": 12, "COUNTS_PER_REV_WIDTH": 13, "TURN_NUMBER_WIDTH": 8},
    cover_depth=12,
    probes={
        f"probe_{name}": f"counter.{name}" for name in ("half", "lowest", "highest", "up", "down")
    },
    breaks=(
        Break(
            "half a turn forwards counts as a wrap backwards",
            "when now > highest else",
            "when now >= highest else",
        ),
        Break(
            "an angle that is not accepted counts as the previous angle",
            "        lowest  <= now - half;\n        highest <= now + half;\n      end if;\n",
            "      end if;\n      lowest  <= now - half;\n      highest <= now + half;\n",
        ),
        Break(
            "`turn_select` changes together with the turn number, one clock too late",
            "u_unsigned(number(1 downto 0)) + u_unsigned'(down & (up or down))",
            "u_unsigned(number(1 downto 0))",
        ),
        Break(
            "a wrap backwards is not counted",
            "        number <= number - 1;\n",
            "        number <= number;\n",
        ),
    ),
)
