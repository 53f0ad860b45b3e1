"""Proofs of the coefficients' memory and sweeps (rtl/coefficients)."""

from __future__ import annotations

from scripts.formal_proofs.proof import Break, Proof


def _both_banks(lanes: int, fold: int) -> dict[str, str]:
    """Return probes that contain all words of both banks of coefficient_memory: 128 bits for each
    lane, last lane first."""
    built = lanes // fold

    def words(bank: int) -> str:
        parts: list[str] = []
        for lane in reversed(range(lanes)):
            column, stored = lane % built + 1, f"stored[{2 * (lane // built) + bank}]"
            kinds = ("amplitudes_of_cosine", "offsets_of_phase", "steps_high", "steps_low")
            for kind, padding in zip(kinds, ("7'd0", "8'd0", "16'd0", ""), strict=True):
                parts += [padding, f"memory.columns_n{column}_{kind}.{stored}"]
        return ",".join(part for part in parts[1:] if part)

    return {f"probe_bank_{bank}": words(bank) for bank in (0, 1)}


def _coefficient_memory_probes(lanes: int, fold: int) -> dict[str, str]:
    parts = {
        "memory": (
            *("active", "phase_bank", "amplitude_bank", "phase_slot", "amplitude_slot"),
            *("swap_waits", "pending_word", "pending_offset", "address", "data", "is_quiet"),
            *("answers", "writing", "selected", "selected_slot", "written", "fill_word"),
        ),
        "memory.swapping": ("copying", "takes_place"),
        "memory.idle": (
            *("filling", "fill_address", "fill_address_1", "fill_place", "fill_under_way"),
            *("fill_stored", "read_stored"),
        ),
    }
    joined = {
        f"probe_{signal}": f"{part}.{signal}"
        for part, signals in parts.items()
        for signal in signals
    }
    return {**joined, **_both_banks(lanes, fold)}


_MEMORY_LIMITS = "no write starts before the last one is acknowledged"

_SHORT_DELAYS = {"PHASE_OFFSET_DELAY": 2, "AMPLITUDE_DELAY": 3, "OFFSET_DELAY": 5}

_SHORTEST_DELAYS = {"PHASE_OFFSET_DELAY": 1, "AMPLITUDE_DELAY": 2, "OFFSET_DELAY": 3}

COEFFICIENT_MEMORY = Proof(
    name="coefficient_memory",
    entity="coefficient_memory",
    claims=(
        "every angle is corrected with the coefficients of a single bank: a swap activates all "
        "acknowledged writes and no part of another write",
        "a swap takes place as soon as the idle bank is filled, a write under way is finished "
        "and a new angle may enter",
        "a write is acknowledged 3 clocks after its start; if a swap waits or the idle bank is "
        "being filled after a swap, the write is acknowledged at most the largest delay + 4 * "
        "LANES + 5 clocks after this swap has taken place",
        "a read returns a word of the idle bank",
    ),
    generics={"LANES": 2, "FOLD": 1, **_SHORT_DELAYS},
    small={"LANES": 2, "FOLD": 1, **_SHORTEST_DELAYS},
    limits=_MEMORY_LIMITS,
    depth=3,
    cover_depth=14,
    probes=_coefficient_memory_probes(2, 1),
    constants={"LANES_MAX": 2},
    words=("*",),
    breaks=(
        Break(
            "a word is written while parts of the pipeline change their bank",
            " and not swap and is_quiet and not reset;\n",
            " and not swap and (is_quiet or swap_marker) and not reset;\n",
        ),
        Break(
            "a word is written while the idle bank is filled",
            " and not swap and is_quiet and not reset;\n",
            " and not swap and (is_quiet or fills) and not reset;\n",
        ),
        Break(
            "a word is written in the clock of the swap",
            " and not swap and is_quiet and not reset;\n",
            " and is_quiet and not reset;\n",
        ),
        Break(
            "a word is written while a swap waits for its angle",
            " and not swap_waits and not swap and",
            " and not swap and",
        ),
        Break(
            "a swap does not wait for a write under way",
            "is_quiet and not writing and swept and turns_swept;\n",
            "is_quiet and not (writing and fills) and swept and turns_swept;\n",
        ),
        Break(
            "amplitudes change their bank one clock too late",
            "if swapped(AMPLITUDE_DELAY - 1) = '1' then\n",
            "if swapped(AMPLITUDE_DELAY) = '1' then\n",
            entity="bank_swap",
        ),
        Break(
            "a swap while the idle bank is filled is lost",
            "(swap or waits) and not may_swap;\n",
            "(swap or waits) and not may_swap and ready;\n",
            entity="bank_swap",
        ),
        Break(
            "the idle bank is not filled",
            "      enters  := fill_enable or (write_now and pending_word);\n",
            "      enters  := write_now and pending_word;\n",
        ),
        Break(
            "the idle bank is filled while parts of the pipeline still use it",
            "  ends           <= copying(LAST_COPY);\n",
            "  ends           <= copying(1);\n",
            entity="bank_swap",
        ),
        Break(
            "the fill ends one word early",
            "        if fill_address = LAST_WORD then\n",
            "        if fill_address = LAST_WORD - 1 then\n",
            entity="idle_words",
        ),
        Break(
            "a word is copied to its neighbour's place",
            "        target  := fill_place;\n",
            "        target  := fill_place + 1;\n",
        ),
        Break(
            "a word that is read back lacks a bit",
            "data(PHASE_WIDTH - 1 downto 0)), 32)",
            "data(PHASE_WIDTH - 2 downto 0)), 32)",
            entity="idle_words",
        ),
    ),
)

COEFFICIENT_MEMORY_FOLDED = Proof(
    name="coefficient_memory_folded",
    entity="coefficient_memory",
    rules_of="coefficient_memory",
    claims=(
        "the same if lanes share a pipeline: in all slots an angle is corrected with the "
        "coefficients of a single bank",
    ),
    generics={"LANES": 2, "FOLD": 2, **_SHORT_DELAYS},
    small={"LANES": 2, "FOLD": 2, **_SHORTEST_DELAYS},
    limits=f"{_MEMORY_LIMITS}; fold_sequence counts the slots",
    depth=3,
    cover_depth=14,
    probes=_coefficient_memory_probes(2, 2),
    constants={"LANES_MAX": 2},
    words=("*",),
    breaks=(
        Break(
            "a swap takes place between two slots of an angle",
            "  may_swap       <= swap_allowed and ready;\n",
            "  may_swap       <= ready;\n",
            entity="bank_swap",
        ),
        Break(
            "amplitudes come from another slot",
            "      slot_of_amplitude <= later(slot, 2 - AMPLITUDE_DELAY);\n",
            "      slot_of_amplitude <= later(slot, 1 - AMPLITUDE_DELAY);\n",
            entity="bank_swap",
        ),
        Break(
            "a word is written for another slot",
            "to_unsigned(lane / BUILT, 3);\n",
            "to_unsigned((lane + 1) / BUILT, 3);\n",
        ),
    ),
)

AMPLITUDE_SWEEP = Proof(
    name="amplitude_sweep",
    entity="amplitude_sweep",
    claims=(
        "an effective amplitude is the product of its own lane's words and modulator in its "
        "bank, and is never larger than the nominal amplitude",
        "while `swept` is high, the effective amplitudes belong to the present words",
        "the square of the speed that the lanes follow is between −1 and 1",
    ),
    generics={"LANES": 2},
    constants={"AMPLITUDE_WIDTH": 19, "MODULATOR_WIDTH": 3, "MODULATOR_FRACTION": 1},
    limits="modulators are between −1 and 1, as the proof of table_conditions states; a sweep "
    "may omit steps of other lanes; the product is between the amplitude and its negative",
    depth=3,
    cover_depth=50,
    cut_signals=(
        "amplitude_sweep/w:nominal_read",
        "amplitude_sweep/w:choice_read",
        "amplitude_sweep/w:multiply_product_3",
    ),
    probes={
        "probe_nominal_read": "sweep.nominal_read",
        "probe_choice_read": "sweep.choice_read",
        "probe_steps": "sweep.multiply_step_1_to_4",
        "probe_is_whole": "sweep.judge_is_whole",
        **{
            f"probe_{name}": f"sweep.multiply_{name}"
            for name in (
                *("amplitude_2", "modulator_2", "product_3", "rounded_4", "held_direction"),
                *("held_a", "held_b", "held_speed", "held_square", "next_speed"),
                "next_square",
            )
        },
    },
    breaks=(
        Break(
            "the amplitude of one bank is written to the other",
            "      bank      <= step_1_to_4(4)(6);\n",
            "      bank      <= step_1_to_4(3)(6);\n",
        ),
        Break(
            "the modulators change within a sweep",
            "      elsif sweep_step = AMPLITUDE_SWEEP_CLOCKS - 1 then\n"
            "        held_direction := direction;\n",
            "      elsif sweep_step(0) = '1' then\n        held_direction := direction;\n",
        ),
        Break(
            "the idle bank has the speed of the active bank",
            "        next_speed(idle)     := idle_speed;\n",
            "        next_speed(idle)     := speed;\n",
        ),
        Break(
            "the product of the most negative amplitude and −1 wraps",
            "      if (rounded_4(AMPLITUDE_WIDTH) xor rounded_4(",
            "      if (rounded_4(AMPLITUDE_WIDTH) and rounded_4(",
        ),
        Break(
            "`swept` does not fall with a write",
            "        is_whole := '0';\n        swept    <= '0';\n",
            "        is_whole := '0';\n",
        ),
        Break(
            "a sweep that began before the last write counts as whole",
            "        is_whole := '0';\n        swept    <= '0';\n",
            "        swept    <= '0';\n",
        ),
    ),
)

TURN_OFFSET_SWEEP = Proof(
    name="turn_offset_sweep",
    entity="turn_offset_sweep",
    claims=(
        "each angle reads the phase offset that was computed for its own turn, from the words "
        "of its bank, so that at a wrap the phase makes only the step of the angle",
        "while `swept` is high, the offsets of the idle bank belong to its present words; "
        "those of the active bank always do",
        "after a swap the turn steps of the active bank are copied whole",
    ),
    generics={"LANES": 2},
    small={"LANES": 1},
    constants={"PHASE_STEP_WIDTH": 36, "PHASE_WIDTH": 12, "TURN_NUMBER_WIDTH": 3},
    limits="from a wrap to the next in the same direction the angle needs half a turn of the "
    "smallest length, one clock a count; swaps come as the proof of compensation_pipeline "
    "states; no reset of the turn number; the arithmetic behind the multiplier is left to the "
    "benches",
    depth=3,
    cover_depth=60,
    quick=False,
    cut_signals=(
        "turn_offset_sweep/w:low_1",
        "turn_offset_sweep/w:high_1",
        "turn_offset_sweep/w:offset_1",
    ),
    probes={
        **{
            f"probe_{name}": f"sweep.{name}"
            for name in (
                *("now", "low_1", "high_1", "offset_1", "to_lane", "to_low", "to_high"),
                *("copied", "copying", "copy_left", "sweep_left"),
            )
        },
        **{
            f"probe_{name}": f"sweep.multiply_{name}"
            for name in (
                *("middle", "above", "below", "turn_2", "low_turn_3", "low_turn_4", "part_2"),
                "offset_2",
            )
        },
        "probe_items": "sweep.multiply_item_1_to_4",
    },
    breaks=(
        Break(
            "the turn is not held for the whole sweep",
            "      if now = FIRST then\n",
            "      if now.part = 0 then\n",
        ),
        Break(
            "the offset of the turn before is not prepared",
            "        below  := turn - 1;\n",
            "        below  := turn + 2;\n",
        ),
        Break(
            "the highest part of a turn step comes from the next lane",
            "          part_2 := resize('0' & u_signed(high_1(high_1'high downto",
            "          part_2 := resize('0' & u_signed(low_1(high_1'high downto",
        ),
        Break(
            "the offset is written to the other bank at the end of a lane",
            "      bank     <= item_1_to_4(4).bank;\n",
            "      bank     <= item_1_to_4(3).bank;\n",
        ),
        Break(
            "`swept` comes after one sweep",
            "        sweep_left <= 2 * SWEEP_CLOCKS + TAIL_CLOCKS;\n",
            "        sweep_left <= SWEEP_CLOCKS + TAIL_CLOCKS;\n",
        ),
        Break(
            "`swept` does not wait for the copy of the turn steps",
            "write_offset or copying or copied) = '1' then\n",
            "write_offset) = '1' then\n",
        ),
        Break(
            "the copy of the turn steps ends before the last lane",
            "        copy_left <= SWEEP_CLOCKS + 4;\n",
            "        copy_left <= SWEEP_CLOCKS - 4;\n",
        ),
    ),
)
