"""Proofs of decoder, sampler, encoder output and processor port (rtl/decoder, rtl/sampler,
rtl/quadrature_output, rtl/top)."""

from __future__ import annotations

from scripts.formal_proofs.proof import Break, Proof

QUADRATURE_OUTPUT = Proof(
    name="quadrature_output",
    entity="quadrature_output",
    claims=(
        "A and B never change in the same clock, for any inputs",
        "successive edges without a reset between them are at least as many clocks apart as "
        "`minimum_spacing` stated when the first edge was decided; `minimum_spacing` may have "
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
)

AXI3_TO_AXI_LITE = Proof(
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
)

QUADRATURE_DECODER = Proof(
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
)

SAMPLER = Proof(
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
)
