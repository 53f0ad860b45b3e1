"""Proofs of the mean of the heads, its failover and the difference of angles (rtl/mean)."""

from __future__ import annotations

from scripts.formal_proofs.proof import Break, Proof

_SETS_SIGNALS = (
    *("now", "base", "ram_place", "place", "waiting", "in_flight", "ram_word", "own_write"),
    "ram_writes",
)

PREPARED_SETS = Proof(
    name="prepared_sets",
    entity="prepared_sets",
    claims=(
        "a prepared set is activated whole: from its first angle on, every word of lanes, mean "
        "and offset is the set's",
        "a swap that a set or the processor requests is refused and reported while its words "
        "must not become active",
        "each write of the processor reaches the bank unchanged before it is acknowledged, "
        "also if it comes while a set is being loaded",
    ),
    generics={"LANES": 1, "HEADS": 3},
    limits="one bus access at a time; the banks acknowledge a write at least one clock after "
    "its start, and none while a swap waits; one load at a time; the processor writes no turn "
    "steps",
    depth=4,
    cover_depth=34,
    quick=False,
    cut_signals=("prepared_sets/w:ram_word",),
    probes={f"probe_{signal}": f"sets.{signal}" for signal in _SETS_SIGNALS},
    breaks=(
        Break(
            "a set is swapped before its last word is written",
            "            if place = OFFSET_PLACE then\n              now        <= WRITTEN;\n",
            "            if place = LANE_WORDS then\n              now        <= WRITTEN;\n",
        ),
        Break(
            "a word of the set is omitted",
            "            elsif place /= OFFSET_PLACE then\n              place <= place + 1;\n",
            "            elsif place = 2 then\n              place <= 4;\n"
            "            elsif place /= OFFSET_PLACE then\n              place <= place + 1;\n",
        ),
        Break(
            "a word is handed over while the memory has not acknowledged the last one",
            "          if in_flight = NOTHING or acknowledged = '1' then\n            own_write",
            "          if in_flight = NOTHING or acknowledged = '1' or own_write = '1' then\n"
            "            own_write",
        ),
        Break(
            "a swap that the processor requests takes place while a set is being written",
            "              swap when now = IDLE else\n",
            "              swap when now = IDLE or now = HAND_OVER else\n",
        ),
        Break(
            "a set is handed over while a write of the processor is not finished",
            "          if in_flight = NOTHING then\n            now <= HAND_OVER;\n",
            "          if true then\n            now <= HAND_OVER;\n",
        ),
        Break(
            "words that must not become active are swapped",
            "  swap_out <= wants and may_activate;\n",
            "  swap_out <= wants;\n",
        ),
        Break(
            "the status says that a refused set was loaded",
            "when (now = ASK_SWAP and may_activate = '1') or now = WAIT_FOR_SWAP else\n",
            "when now = HAND_OVER or now = ASK_SWAP or now = WAIT_FOR_SWAP else\n",
        ),
    ),
)

HEAD_FAILOVER = Proof(
    name="head_failover",
    entity="head_failover",
    further={"mean_words": ("HEADS",)},
    claims=(
        "a head that is left out has the weight 0 in the active words, is not used and is not "
        "the carrier, for any words of the processor or of a prepared set",
        "a head that is left out comes back only after it has seen its index again",
        "a swap of words that use a left-out head is refused and reported; the active words stay",
    ),
    generics={"LANES": 1, "HEADS": 3, "INTERVAL_BITS": 5},
    limits="any head may fail in any clock; prepared_sets makes swaps as its proof states",
    depth=4,
    cover_depth=20,
    cut=("head_watch*", "parity_sum*"),
    probes={
        "probe_pending": "words.pending",
        "probe_wants_set": "decides.wants_set",
        "probe_wanted_set": "decides.wanted_set",
        "probe_swap_refused": "decides.swap_refused",
    },
    breaks=(
        Break(
            "a swap that the processor requests uses a left-out head again",
            "      may_activate <= not (or (idle_used and barred))",
            "      may_activate <= not (or (idle_used and barred and (barred'range => busy)))",
        ),
        Break(
            "a set that uses the head that it should leave out is activated",
            "      may_activate <= not (or (idle_used and barred))",
            "      may_activate <= (busy or not (or (idle_used and barred)))",
        ),
        Break(
            "a left-out head is the carrier",
            " and (idle_carrier_used or not (busy or (or left_out)));\n",
            ";\n",
        ),
        Break(
            "a swap that the processor requests ends a failover",
            "        set_in_force <= to_unsigned(OWN_WORDS_SET, 3);\n      end if;\n\n",
            "        set_in_force <= to_unsigned(OWN_WORDS_SET, 3);\n"
            "        left_out     <= (others => '0');\n      end if;\n\n",
        ),
        Break(
            "a set uses a left-out head that has not seen its index again",
            "          if uses_one(wanted_set, left_out) and has_index = '0' then\n",
            "          if uses_one(wanted_set, left_out) and rearming /= 0 then\n",
        ),
        Break(
            "a head comes back because of an index from before the failover",
            "when rearming = 0 and (indices_seen and left_out) = left_out else",
            "when (indices_seen and left_out) = left_out else",
        ),
        Break(
            "a head comes back without its index",
            "      may_return := '1' when (or left_out) = '1' and has_index = '1'\n",
            "      may_return := '1' when (or left_out) = '1'\n",
        ),
        Break(
            "a head that is not used keeps its weight",
            "          if idle(USED_FIRST + head) = '0' then\n",
            "          if idle(USED_FIRST + head) = '0' and head = 0 then\n",
            entity="mean_words",
        ),
        Break(
            "a word is written while a swap waits",
            "pending and not hold_writes and not reset;\n",
            "pending and not reset;\n",
            entity="mean_words",
        ),
        Break(
            "a refused swap is not reported",
            " or refused or set_refused;\n",
            " or set_refused;\n",
        ),
    ),
)

TURN_DIFFERENCE = Proof(
    name="turn_difference",
    entity="turn_difference",
    claims=(
        "the output is the difference of two angles modulo the turn, for any counts_per_rev "
        "and a new pair of angles in every clock",
        "the difference is along the shorter way round",
    ),
    limits="angles are below counts_per_rev, which is constant",
    depth=5,
    cover_depth=8,
    breaks=(
        Break(
            "a difference of exactly +half a turn is not folded to −half a turn",
            "excess_2(excess_2'high) xnor falls;",
            "(excess_2(excess_2'high) xnor falls) and (or excess_2);",
        ),
        Break(
            "a turn is subtracted from a difference of exactly −half a turn",
            "excess_2(excess_2'high) xnor falls;",
            "(excess_2(excess_2'high) xnor falls) or not (or excess_2);",
        ),
        Break(
            "a turn is added instead of subtracted",
            "(turn_2'range => is_longer), falls);",
            "(turn_2'range => is_longer), not falls);",
        ),
        Break(
            "an angle's highest bit is read as a sign",
            "u_signed('0' & minuend)",
            "resize(u_signed(minuend), straight_1'length)",
        ),
    ),
)
