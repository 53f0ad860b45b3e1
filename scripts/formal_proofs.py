"""Lists the proofs of ``make formal`` and the faults that each must notice; see
scripts/formal.py."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Break:
    """Fault in the VHDL: ``old``, which occurs exactly once in ``entity``, is replaced by
    ``new``."""

    name: str
    old: str
    new: str
    entity: str = ""  # empty: the fault is in the entity of the proof


@dataclass(frozen=True)
class Proof:
    """Proof of an entity: the entity, its rules, and the faults that the proof must notice."""

    name: str
    entity: str
    claims: tuple[str, ...]
    breaks: tuple[Break, ...]
    depth: int  # length k of the induction, in clocks
    cover_depth: int  # clocks within which each cover statement must be reachable
    limits: str = ""  # assumptions of the rules beyond the protocol, for the table
    # Values of the entity's generics; the rules have parameters with the same names.
    generics: Mapping[str, int] = field(default_factory=dict)
    # Further entities that the rules connect to the proof's entity, each with the names of its
    # generics.
    beside: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    # Smaller generics for the search for a counterexample, because this search goes clock by clock
    # and is slower than a proof.
    small: Mapping[str, int] = field(default_factory=dict)
    # Wires of the rules, and the signals of the entity to which they are connected.
    probes: Mapping[str, str] = field(default_factory=dict)
    # Constants of number_formats_pkg that have smaller values in the proof, so that memories are
    # smaller.
    constants: Mapping[str, int] = field(default_factory=dict)
    # Memories (patterns of names) whose words become signals, to which a probe can refer.
    words: tuple[str, ...] = ()
    # Modules (patterns of names) that are removed: their outputs may have any value.
    cut: tuple[str, ...] = ()
    # Signals (module/w:name) whose drivers are cut, so that they may have any value in any clock.
    cut_signals: tuple[str, ...] = ()
    quick: bool = True  # whether `make test` runs this proof
    # Name of the proof whose rules this proof uses; empty: this proof has its own rules.
    rules_of: str = ""

    @property
    def rules(self) -> str:
        """Return the name of the module of the rules, which is in a file of formal/ with the same
        name."""
        return f"{self.rules_of or self.name}_rules"


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
    signals = (
        *("active", "phase_bank", "amplitude_bank", "phase_slot", "amplitude_slot", "copying"),
        *("swap_waits", "swap_now", "pending_word", "pending_offset", "address", "data"),
        *("is_quiet", "answers", "writing", "filling", "fill_address", "fill_address_1"),
        *("fill_address_2", "fill_under_way", "fill_stored", "fill_word", "read_stored"),
        *("selected", "selected_slot", "written"),
    )
    joined = {f"probe_{signal}": f"memory.{signal}" for signal in signals}
    return {**joined, **_both_banks(lanes, fold)}


_MEMORY_LIMITS = "no write starts before the last one is acknowledged"
_SHORT_DELAYS = {"PHASE_OFFSET_DELAY": 2, "AMPLITUDE_DELAY": 3, "OFFSET_DELAY": 5}
_SHORTEST_DELAYS = {"PHASE_OFFSET_DELAY": 1, "AMPLITUDE_DELAY": 2, "OFFSET_DELAY": 3}

COEFFICIENT_MEMORY = (
    Proof(
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
                " and not swap and (is_quiet or copying(2)) and not reset;\n",
            ),
            Break(
                "a word is written while the idle bank is filled",
                " and not swap and is_quiet and not reset;\n",
                " and not swap and (is_quiet or filling) and not reset;\n",
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
                "is_quiet and not (writing and filling) and swept and turns_swept;\n",
            ),
            Break(
                "amplitudes change their bank one clock too late",
                "if swapped(AMPLITUDE_DELAY - 1) = '1' then\n",
                "if swapped(AMPLITUDE_DELAY) = '1' then\n",
            ),
            Break(
                "a swap while the idle bank is filled is lost",
                "(swap or swap_waits) and not may_swap;\n",
                "(swap or swap_waits) and not may_swap and not filling;\n",
            ),
            Break(
                "the idle bank is not filled",
                "      enters  := fill_under_way(2) or (write_now and pending_word);\n",
                "      enters  := write_now and pending_word;\n",
            ),
            Break(
                "the idle bank is filled while parts of the pipeline still use it",
                "      if copying(LAST_COPY) = '1' then\n",
                "      if copying(1) = '1' then\n",
            ),
            Break(
                "the fill ends one word early",
                "        if fill_address = LAST_WORD then\n",
                "        if fill_address = LAST_WORD - 1 then\n",
            ),
            Break(
                "a word is copied to its neighbour's place",
                "        target  := fill_address_2;\n",
                "        target  := fill_address_2 + 1;\n",
            ),
            Break(
                "a word that is read back lacks a bit",
                "data(PHASE_WIDTH - 1 downto 0)), 32)",
                "data(PHASE_WIDTH - 2 downto 0)), 32)",
            ),
        ),
    ),
    Proof(
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
                "may_swap  <= swap_allowed and is_quiet",
                "may_swap  <= is_quiet",
            ),
            Break(
                "amplitudes come from another slot",
                "      amplitude_slot <= later(slot, 2 - AMPLITUDE_DELAY);\n",
                "      amplitude_slot <= later(slot, 1 - AMPLITUDE_DELAY);\n",
            ),
            Break(
                "a word is written for another slot",
                "to_unsigned(lane / BUILT, 3);\n",
                "to_unsigned((lane + 1) / BUILT, 3);\n",
            ),
        ),
    ),
)

_SETS_SIGNALS = (
    *("now", "base", "ram_place", "place", "waiting", "in_flight", "ram_word", "own_write"),
    "ram_writes",
)

FAILOVER = (
    Proof(
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
                "          if in_flight = NOTHING or acknowledged = '1' then\n"
                "            own_write",
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
    ),
    Proof(
        name="head_failover",
        entity="head_failover",
        beside={"mean_words": ("HEADS",)},
        claims=(
            "a head that is left out has the weight 0 in the active words, is not used and is not "
            "the carrier, for any words of the processor or of a prepared set",
            "a head that is left out comes back only after it has seen its index again",
            "a swap of words that use a left-out head is refused and reported; the active words "
            "stay",
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
    ),
)

_PIPELINE_SIGNALS = (
    *("active", "step_bank", "phase_bank", "amplitude_bank", "idle_bank", "idle_constant"),
    *("active_constant", "copying", "swap_waits", "is_quiet", "answers", "writing", "filling"),
    *("write_now", "is_written", "is_turn_step", "swept", "turns_swept", "fill_address"),
    *("fill_under_way", "selected", "pending_word", "pending_offset", "pending_turn"),
)
_TABLE_SIGNALS = (
    *("asked", "stores", "copies", "to_read", "to_write", "looked_up", "copy", "left_clear"),
)

SWAP = (
    Proof(
        name="compensation_pipeline",
        entity="compensation_pipeline",
        claims=(
            "a swap is atomic over everything: each angle uses one bank of phase steps, phase "
            "offsets of its turn, amplitudes, offset and local table",
            "no word of a bank is written while an angle in the pipeline uses this bank",
            "a swap waits until both sweeps have prepared the idle bank, and takes over whole "
            "writes only; the local table swaps with the lanes or not at all",
        ),
        generics={"LANES": 1, "MODULATORS": True, "LOCAL_TABLE": True, "REAL_ORDERS": True},
        constants={"LANES_MAX": 2},
        limits="one access to the lanes and one to the table at a time; sweeps and memories are "
        "left out: their outputs may have any value",
        depth=3,
        cover_depth=32,
        cut=(
            "phase_unit*",
            "harmonic_unit*",
            "error_compensation*",
            "delay_line*",
            "turn_counter",
            "amplitude_sweep*",
            "turn_offset_sweep*",
            "coefficient_banks*",
            "local_table",
        ),
        probes={
            **{f"probe_{name}": f"pipeline.coefficients.{name}" for name in _PIPELINE_SIGNALS},
            "probe_take_over": "pipeline.coefficients.real_orders_too_turn_sweep.take_over",
            **{
                f"probe_{name}": f"pipeline.table_over_the_turn_banks.{name}"
                for name in _TABLE_SIGNALS
            },
            "probe_table_active": "pipeline.table_over_the_turn_banks.points.bank",
            "probe_table_bank": "pipeline.table_over_the_turn_banks.write_bank",
        },
        breaks=(
            Break(
                "a swap that waits does not wait for the effective amplitudes",
                " and not writing and swept and turns_swept;\n",
                " and not writing and (swept or swap_waits) and turns_swept;\n",
                entity="coefficient_memory",
            ),
            Break(
                "a swap that waits does not wait for the phase offsets of the turns",
                " and not writing and swept and turns_swept;\n",
                " and not writing and swept and (turns_swept or swap_waits);\n",
                entity="coefficient_memory",
            ),
            Break(
                "amplitudes change their bank one clock too late",
                "if swapped(AMPLITUDE_DELAY - 1) = '1' then\n",
                "if swapped(AMPLITUDE_DELAY) = '1' then\n",
                entity="coefficient_memory",
            ),
            Break(
                "the offset changes with the phase offsets, before its angle arrives",
                "      if copying(OFFSET_DELAY) = '1' then\n",
                "      if copying(PHASE_OFFSET_DELAY) = '1' then\n",
                entity="coefficient_memory",
            ),
            Break(
                "a word is written while a swap waits",
                " and not swap_waits and not swap and",
                " and not swap and",
                entity="coefficient_memory",
            ),
            Break(
                "turn steps are taken over while angles use the idle bank",
                "        take_over    => copying(LAST_COPY),\n",
                "        take_over    => copying(1),\n",
                entity="coefficient_memory",
            ),
            Break(
                "the local table swaps when the swap is requested, not when it takes place",
                "        swap_comes     => new_bank_comes,\n",
                "        swap_comes     => swap,\n",
            ),
            Break(
                "a word of the local table is written while a swap waits",
                "        hold           => swap or swap_waits,\n",
                "        hold           => swap,\n",
            ),
            Break(
                "the local table swaps while a write of one of its words waits",
                "  takes  <= swap_comes and asked;\n",
                "  takes  <= swap_comes and (asked or to_write);\n",
                entity="local_table_banks",
            ),
            Break(
                "the place of the windows is copied while angles use it",
                "        left_clear <= LOCAL_TABLE_LATENCY;\n",
                "        left_clear <= LOCAL_TABLE_LATENCY - 2;\n",
                entity="local_table_banks",
            ),
            Break(
                "a point of the active bank is written",
                "  write_bank <= active when copy = READS else\n",
                "  write_bank <= active when copy = READS or copy = FREE else\n",
                entity="local_table_banks",
            ),
        ),
    ),
    Proof(
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
    ),
    Proof(
        name="turn_offset_sweep",
        entity="turn_offset_sweep",
        claims=(
            "each angle reads the phase offset that was computed for its own turn, from the words "
            "of its bank, so that over a wrap the phase makes the step of the angle only",
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
    ),
)

CONDITIONS = (
    Proof(
        name="stop_operator",
        entity="stop_operator",
        claims=(
            "the place that gives the direction h stays between −width and width, for any motion "
            "and any change of width and dead zone",
            "once the place is known, it is the place of the stop operator, from whichever place "
            "this operator began",
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
    ),
    Proof(
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
                "        if size > (\"000\" & slew & '0') then\n",
                "        if size > 0 then\n",
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
    ),
)

PROOFS = (
    Proof(
        name="quadrature_output",
        entity="quadrature_output",
        claims=(
            "A and B never change in the same clock, for any inputs",
            "successive edges without a reset between them are at least `minimum_spacing` clocks "
            "apart, with the value at the decision of the first edge; `minimum_spacing` may have "
            "any value and change in any clock",
            "A and B always have the levels of the output's count, also through a reset",
            "Z never rises before an index has set the angle's zero, and a gated Z never rises "
            "outside its state",
            "from 7 clocks after a fault the output stands until the fault is cleared",
        ),
        depth=5,
        cover_depth=16,
        probes={
            "probe_up": "edges.follow_up",
            "probe_down": "edges.follow_down",
            "probe_spacing": "edges.follow_spacing",
            "probe_may_step": "edges.follow_may_step",
            "probe_phase": "edges.follow_phase",
            "probe_phase_then": "edges.follow_phase_then",
            "probe_referenced_then": "edges.follow_referenced_then",
            "probe_output": "edges.follow_output",
            "probe_following": "edges.follow_following",
        },
        breaks=(
            Break(
                "Z rises on an angle without reference",
                "      referenced_then := referenced_then(1 downto 0) & referenced;\n",
                "      referenced_then := (referenced_then(1) or referenced_then(2))"
                " & referenced_then(0) & referenced;\n",
            ),
            Break(
                "while A and B are exchanged, both pins show the same signal",
                "        b <= a_level xor invert_b;\n",
                "        b <= b_level xor invert_b;\n",
            ),
            Break(
                "a gated Z begins one state too early",
                "(resize(behind_state, 3) ?< counts_of(z_width))",
                "(resize(behind_state, 3) ?<= counts_of(z_width))",
            ),
            Break(
                "the output goes on after a fault",
                "      following := enable and not cannot_keep_up;\n",
                "      following := enable and not (cannot_keep_up and clear);\n",
            ),
            Break(
                "after a standstill A and B have the levels of another count",
                "        output(1 downto 0) := u_signed(place_of_output);\n",
                "        output(1 downto 0) := corrected_position(1 downto 0);\n",
            ),
            Break(
                "B follows the wrong bit of the phase",
                "      b_level := phase_then(1);\n",
                "      b_level := phase_then(0);\n",
            ),
            Break(
                "the phase is not held while `enable` is low",
                "      if following = '1' then\n        phase := ",
                "      if following = '0' then\n"
                "        phase := u_unsigned(corrected_position(1 downto 0));\n"
                "      else\n        phase := ",
            ),
            Break(
                "edges come one clock too early",
                "        if spacing <= 2 then\n",
                "        if spacing <= 3 then\n",
            ),
            Break(
                "a spacing of two clocks is ignored",
                "        if minimum_spacing <= 1 then\n",
                "        if minimum_spacing <= 2 then\n",
            ),
        ),
    ),
    Proof(
        name="axi3_to_axi_lite",
        entity="axi3_to_axi_lite",
        claims=(
            "on AXI3 and AXI4-Lite a valid address, beat or answer stays valid and unchanged until "
            "it is taken; none is valid after a reset",
            "each read burst gets all its beats, with RLAST at the last, and each write burst one "
            "answer after its last beat, all with the burst's ID; there are no other answers",
        ),
        limits="the slave answers a write after it has taken address and data",
        depth=4,
        cover_depth=16,
        probes={
            "probe_writing": "bridge.writing",
            "probe_reading": "bridge.reading",
            "probe_write_now": "bridge.write_now",
            "probe_read_now": "bridge.read_now",
        },
        breaks=(
            Break(
                "an address is withdrawn before it is taken",
                "          if m_axil_response.awready = '1' then\n",
                "          if m_axil_response.awready = '1' or m_axil_response.wready = '1' then\n",
            ),
            Break(
                "write data change while they wait",
                "        when WRITE_ACCESS =>\n",
                "        when WRITE_ACCESS =>\n          m_axil_request.wdata <= s_axi_wdata;\n",
            ),
            Break(
                "a write answer lasts one clock only",
                "          if s_axi_bready = '1' then\n",
                "          if true then\n",
            ),
            Break(
                "a read beat changes while it waits",
                "        when READ_ANSWER =>\n",
                "        when READ_ANSWER =>\n          s_axi_rdata <= m_axil_response.rdata;\n",
            ),
            Break(
                "a read address is withdrawn before it is taken",
                "          if m_axil_response.arready = '1' then\n",
                "          if true then\n",
            ),
            Break(
                "a reset does not clear a write address",
                "        m_axil_request.awvalid <= '0';\n"
                "        m_axil_request.wvalid  <= '0';\n      end if;",
                "        m_axil_request.wvalid  <= '0';\n      end if;",
            ),
            Break(
                "RLAST comes one beat too early",
                "          if read_now.beats = 0 then\n",
                "          if read_now.beats <= 1 then\n",
            ),
            Break(
                "a beat without strobes ends the burst",
                "              done := true;\n            end if;\n          end if;\n",
                "              writing <= WRITE_ANSWER;\n            end if;\n          end if;\n",
            ),
        ),
    ),
    Proof(
        name="quadrature_decoder",
        entity="quadrature_decoder",
        claims=(
            "the position equals that of a reference model, which computes it from the samples of "
            "the pins and a table",
            "the position never moves by more than one count per clock",
            "the zero never moves without `zero_again`; lost counts are put back only with `heal`, "
            "and only when the zero moves",
        ),
        limits="filter_length is at most 7 clocks and may change in any clock",
        depth=7,
        cover_depth=24,
        probes={
            "probe_lasted": "decoder.filter.follow_lasted",
            "probe_level": "decoder.filter.follow_level",
        },
        breaks=(
            Break(
                "the decoder counts backwards",
                "        up   <= a xor b_before;\n",
                "        up   <= b xor a_before;\n",
                entity="edge_counter",
            ),
            Break(
                "the zero moves because the other head agrees, without `zero_again`",
                "                and zero_again and is_latest and ",
                "                and (zero_again or other_head_agrees) and is_latest and ",
                entity="index_zero",
            ),
            Break(
                "lost counts are put back without `heal`",
                "        if (heal = '1' and is_small = '1') then\n",
                "        if (is_small = '1') then\n",
                entity="index_zero",
            ),
            Break(
                "the filter passes a level one clock too early",
                "        elsif (lasted(i) >= filter_length) then\n",
                "        elsif (lasted(i) + 1 >= filter_length) then\n",
                entity="glitch_filter",
            ),
            Break(
                "a level of the first clock after a reset is not filtered",
                "      reset         => settling(settling'high - 1),\n",
                "      reset         => preload,\n",
            ),
            Break(
                "a simultaneous change of both pins is counted",
                "  comes     <= (a_changes xor b_changes) and not preload;\n",
                "  comes     <= (a_changes or b_changes) and not preload;\n",
                entity="edge_counter",
            ),
        ),
    ),
    Proof(
        name="sampler",
        entity="sampler",
        claims=(
            "the sampler never writes a capture bank that belongs to the processor",
            "the processor reads no other bank",
            "the processor keeps bank and header until it releases them",
        ),
        generics={"DEPTH": 3},
        limits="triggers may come in any clock",
        depth=5,
        cover_depth=24,
        cut=("sample_trigger*", "capture_memory*"),
        probes={
            "probe_write_enable": "capture.write_enable",
            "probe_write_address": "capture.write_address",
            "probe_memory_read_address": "capture.memory_read_address",
            "probe_readable": "capture.read_ready_bank_readable",
            "probe_handing_over": "capture.fill_handing_over",
            "probe_filling_bank": "capture.fill_filling_bank",
            "probe_first": "capture.fill_first",
            "probe_samples": "capture.fill_samples",
            "probe_is_last": "capture.fill_is_last",
        },
        breaks=(
            Break(
                "a bank is handed over although the processor has not released the other bank",
                "          if owned = '1' then\n",
                "          if owned = '1' and overrun = '1' then\n",
            ),
            Break(
                "a bank is handed over before its last word is written",
                "            handing_over        := '1';\n",
                "            handing_over        := '1';\n            owned := '1';\n",
            ),
            Break(
                "a bank is one sample too long",
                "      is_before    := samples ?= DEPTH - 2;\n",
                "      is_before    := samples ?= DEPTH - 1;\n",
            ),
            Break(
                "the banks are not exchanged",
                "            filling_bank := not filling_bank;\n",
                "",
            ),
            Break(
                "a read goes to the bank being filled",
                "      if is_inside and ready_bank = '1' then\n",
                "      if is_inside and ready_bank = '0' then\n",
            ),
            Break(
                "the header of the processor's bank changes while the next turn is captured",
                "        samples      := samples + 1;\n",
                "        samples      := samples + 1;\n"
                "        header_sample_count <= resize(samples, 16);\n",
            ),
        ),
    ),
    *COEFFICIENT_MEMORY,
    Proof(
        name="arctrue_core",
        entity="arctrue_core",
        claims=(
            "on the core's AXI4-Lite port an answer stays valid and unchanged until it is taken; "
            "no answer is valid after a reset; each answer belongs to an access that was taken "
            "before it",
            "coefficient memory and capture are accessed only at legal words of the access that "
            "was taken, and a read returns the word that they supply",
            "a read waits for one write at most, and a write for one read",
        ),
        generics={"LANES": 1, "CAPTURE_DEPTH": 2},
        limits="the master follows AXI4-Lite; the other units answer as their proofs state, and "
        "the words that they return may have any value",
        depth=3,
        cover_depth=12,
        quick=False,
        cut=(
            "compensation_pipeline*",
            "delay_line*",
            "encoder_heads*",
            "instrument_signals*",
            "quadrature_output*",
            "rearm_control*",
            "sampler*",
            "processor_watch*",
            "fault_outputs*",
        ),
        cut_signals=(
            "arctrue_registers/w:field_storage",
            "arctrue_registers/w:rbuf_storage",
        ),
        probes={
            "probe_bank_ready": "core.bank_ready",
            "probe_capture_read": "core.capture_read",
            "probe_capture_valid": "core.capture_valid",
            "probe_capture_data": "core.capture_data",
            "probe_write_acknowledge": "core.write_acknowledge",
            "probe_coefficient_read": "core.coefficient_read",
            "probe_coefficient_write": "core.coefficient_write",
            "probe_coefficient_data": "core.coefficient_data",
            "probe_local_done": "core.local_done",
            "probe_mean_read_then": "core.mean_read_then",
            "probe_turns_under_way": "core.turns_under_way",
            "probe_offset_read": "core.offset_read",
            "probe_offset_write": "core.offset_write",
            "probe_offset_data": "core.offset_data",
            "probe_read_under_way": "core.read_under_way",
            "probe_state": "core.processor.bus_port.state",
            "probe_taken": "core.processor.bus_port.taken",
            "probe_is_write": "core.processor.bus_port.is_write",
            "probe_register_read": "core.processor.register_read",
            "probe_register_request": "core.processor.register_request",
            "probe_register_writes": "core.processor.register_writes",
            "probe_address": "core.processor.bus_port.address",
            "probe_data": "core.processor.bus_port.write_data",
            "probe_strobes": "core.processor.bus_port.write_strobes",
            **{
                f"probe_to_{unit}": f"core.processor.guard.to_{unit}"
                for unit in ("mean", "heads", "conditions", "sets", "local", "turns")
            },
            "probe_to_registers": "core.processor.guard.to_registers",
            "probe_to_coefficients": "core.processor.guard.to_coefficients",
            "probe_to_offset": "core.processor.guard.to_offset",
            "probe_to_capture": "core.processor.guard.to_capture",
            "probe_refused": "core.processor.guard.refused",
        },
        breaks=(
            Break(
                "a write address is taken without its data",
                "          choose_write  := s_axil_request.awvalid and s_axil_request.wvalid and ",
                "          choose_write  := s_axil_request.awvalid and ",
                entity="axi_lite_access",
            ),
            Break(
                "reads always precede writes",
                " and not (s_axil_request.arvalid and is_write);\n",
                " and not s_axil_request.arvalid;\n",
                entity="axi_lite_access",
            ),
            Break(
                "read data change while they wait",
                "        when ANSWER =>\n",
                "        when ANSWER =>\n          s_axil_response.rdata <= data;\n",
                entity="axi_lite_access",
            ),
            Break(
                "an answer lasts one clock only",
                "          if (is_write = '1' and s_axil_request.bready = '1') or ",
                "          if is_write = '1' or ",
                entity="axi_lite_access",
            ),
            Break(
                "a reset does not withdraw an answer",
                "        is_write <= '0';\n        state <= IDLE;\n",
                "        is_write <= '0';\n",
                entity="axi_lite_access",
            ),
            Break(
                "the verdict on an access changes with the state of the bank while a word is read",
                "      if judge = '1' then\n",
                "      if judge = '1' or is_write = '0' then\n",
                entity="access_guard",
            ),
            Break(
                "a coefficient of a lane that is not built is written",
                "and not partial and is_at_most(lane, LANES - 1);\n",
                "and not partial and is_at_most(lane, LANES);\n",
                entity="access_guard",
            ),
            Break(
                "a byte of the coefficient offset is written",
                "      offset       := is_offset and not partial;\n",
                "      offset       := is_offset;\n",
                entity="access_guard",
            ),
            Break(
                "a word of the capture mixes with another unit's word",
                "              or (capture_data and to_capture);\n",
                "              or capture_data;\n",
                entity="register_access",
            ),
            Break(
                "a read of a coefficient is acknowledged twice",
                "      read_under_way <= read_under_way(0) & ",
                "      read_under_way <= (read_under_way(0) or read_under_way(1)) & ",
            ),
        ),
    ),
    *FAILOVER,
    Proof(
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
                "above_2    := twice - turn;",
                "above_2    := twice - turn - 1;",
            ),
            Break(
                "a turn is subtracted from a difference of exactly −half a turn",
                "above_2(above_2'high) = '0' then",
                "above_2(above_2'high) = '0' or below_2 = 0 then",
            ),
            Break(
                "a turn is added instead of subtracted",
                "difference <= less_2;",
                "difference <= more_2;",
            ),
            Break(
                "an angle's highest bit is read as a sign",
                "u_signed('0' & minuend)",
                "resize(u_signed(minuend), straight_1'length)",
            ),
        ),
    ),
    Proof(
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
            f"probe_{name}": f"counter.{name}"
            for name in ("half", "lowest", "highest", "up", "down")
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
    ),
    *CONDITIONS,
    *SWAP,
)
