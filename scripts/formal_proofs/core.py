"""Proofs of the pipeline and of the whole core (rtl/core)."""

from __future__ import annotations

from scripts.formal_proofs.proof import Break, Proof

_PIPELINE_SIGNALS = (
    *("active", "step_bank", "phase_bank", "amplitude_bank", "idle_bank", "idle_constant"),
    *("active_constant", "swap_waits", "is_quiet", "answers", "writing", "write_now", "selected"),
    *("is_written", "is_turn_step", "swept", "turns_swept", "pending_word", "pending_offset"),
    *("pending_turn", "swapping.copying", "idle.filling", "idle.fill_address"),
    "idle.fill_under_way",
)

_TABLE_SIGNALS = (
    *("asked", "stores", "copies", "to_read", "to_write", "looked_up", "copy", "left_clear"),
)

COMPENSATION_PIPELINE = Proof(
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
        **{
            f"probe_{name.rpartition('.')[2]}": f"pipeline.coefficients.{name}"
            for name in _PIPELINE_SIGNALS
        },
        "probe_take_over": "pipeline.coefficients.real_orders_too_turn_sweep.take_over",
        **{
            f"probe_{name}": f"pipeline.table_over_the_turn_banks.{name}" for name in _TABLE_SIGNALS
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
            entity="bank_swap",
        ),
        Break(
            "the offset changes with the phase offsets, before its angle arrives",
            "  offset_changes <= copying(OFFSET_DELAY);\n",
            "  offset_changes <= copying(PHASE_OFFSET_DELAY);\n",
            entity="bank_swap",
        ),
        Break(
            "a word is written while a swap waits",
            " and not swap_waits and not swap and",
            " and not swap and",
            entity="coefficient_memory",
        ),
        Break(
            "turn steps are taken over while angles use the idle bank",
            "        take_over    => all_are_swapped,\n",
            "        take_over    => swap_marker,\n",
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
)

ARCTRUE_CORE = Proof(
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
)
