-- SPDX-License-Identifier: Apache-2.0
--
-- # arctrue_core
--
-- Contains the whole data path: it decodes the encoder heads, samples their positions for the calibration, corrects the
-- position of head 1, and outputs the corrected position as an encoder signal. A processor accesses the core over
-- AXI4-Lite (see the register map) and gets one interrupt line. Source: figures 3 and 5 to 7 and section 3 of the
-- paper.
--
-- **Units**, in the order of the data: rearm_control, encoder_heads, mean_unit (with the mean), sampler,
-- compensation_pipeline with table_conditions, quadrature_output, processor_watch, fault_outputs, instrument_signals
-- and register_access.
--
-- **Heads.** By default the core has two heads and corrects head 1. With MEAN the core corrects the weighted mean of
-- all heads; one head, chosen at run time, is the carrier, whose reading enters the pipeline (head_mean). With HEADS =
-- 3 or 4 the mean is always built, and heads 3 and 4 are decoded and captured too. head_registers serves their
-- settings, faults and snapshot. With the mean, the levels of each head can be delayed (level_delay).
--
-- **Latency.** 29 clocks from the angle of head 1 to the corrected angle, 30 with more than two heads.
-- The quadrature_decoder before this path and the quadrature_output after it add the latencies that their headers
-- state. With a FOLD above 1, the core accepts one angle every FOLD clocks, and the latency, counted from an accepted
-- angle, is FOLD - 1 clocks longer (compensation_pipeline).
--
-- **Number formats.** Addresses are in bytes; the register map states all other formats.
--
-- **Rotation.** A lane is the logic that adds one harmonic to the correction. ROTATION selects how a lane computes its
-- cosine: `cordic`, as in the paper, or `table` (table_rotation), which needs fewer look-up tables. Both have the same
-- latency and formats. The register `capability` shows the choice.
--
-- **Modulators.** With MODULATORS the amplitudes of lanes can follow the direction of motion, the speed or a word of
-- the processor (table_conditions); the latency does not change. The register `capability` shows whether the core has
-- modulators.
--
-- **Failover.** With FAILOVER and three or four heads, the core leaves a failed head out of the mean: it activates
-- coefficients and weights that the processor has prepared for the loss of this head (head_failover).
--
-- **Local table.** With LOCAL_TABLE a table over the turn, or over windows of the turn, corrects errors that a sum of
-- orders cannot represent (local_table_banks).
--
-- **Real orders.** With REAL_ORDERS the order of a lane need not be an integer: its phase continues from turn to turn
-- (turn_counter, turn_offset_sweep).
--
-- **Events.** With EVENTS the edges of the probe, the pulses of the position compare, or both, as the processor selects,
-- wait in a queue for the processor (event_queue).
--
-- **Compensation** is applied while `control.compensate` is set and head 1 (with the mean: the carrier and each used
-- head) has seen its index. The core subtracts the correction from the head's position. The first index does not change
-- this position, and the ramp then moves the correction from 0 to its value. So the output makes no step when the index
-- is found.
--
-- **Clock.** The core has one clock. The times in seconds that the register map names are for 100 MHz. The pins of the
-- encoders, `sync_in` and `probe_in` are asynchronous; every other port is synchronous to `clock`.
--
-- **Reset** is synchronous. It stops and clears everything, with these exceptions. Both banks of all words that a swap
-- activates (coefficients, turn steps, mean, local table, conditions), the prepared sets, and the levels of out_a and
-- out_b keep their values. `driver_enable` keeps its value for 2²⁰ clocks (10 ms at 100 MHz) or until the processor
-- enables the output (fault_outputs). Hold the reset for at least 64 clocks, so that the pipeline contains no angle
-- from before the reset.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.arctrue_registers_pkg.all;
  use work.axi_lite_pkg.all;
  use work.conditions_pkg.all;
  use work.decoder_pkg.all;
  use work.mean_pkg.all;
  use work.number_formats_pkg.all;
  use work.signals_pkg.all;

entity arctrue_core is
  generic (
    LANES         : positive range 1 to LANES_MAX := LANES_DEFAULT;         -- number of harmonic lanes
    CAPTURE_DEPTH : positive range 2 to 16384     := CAPTURE_DEPTH_DEFAULT; -- number of samples in a capture bank
    FOLD          : positive range 1 to 8         := 1;                     -- number of lanes that share a pipeline: 1, 2, 4 or 8
    HEADS         : positive range 2 to HEADS_MAX := 2;
    MEAN          : boolean                       := false;                 -- build the mean also for two heads
    ROTATION      : string                        := "cordic";              -- or "table": method of computing the cosine
    MODULATORS    : boolean                       := false;                 -- amplitudes can follow motion or a processor word
    FAILOVER      : boolean                       := false;                 -- a failed head of three or four can be left out of the mean
    LOCAL_TABLE   : boolean                       := false;                 -- a table corrects errors that a sum of orders cannot represent
    REAL_ORDERS   : boolean                       := false;                 -- the order of a lane need not be an integer
    EVENTS        : boolean                       := false                  -- edges of the probe and compare pulses are queued
  );
  port (
    clock           : in    std_ulogic;
    reset           : in    std_ulogic;
    -- AXI4-Lite slave, 512 KiB, see axi_lite_pkg
    s_axil_request  : in    axi_lite_request;
    s_axil_response : out   axi_lite_response;
    interrupt       : out   std_ulogic;                     -- high while an enabled event is set
    -- Reference head, asynchronous
    head1_a         : in    std_ulogic;
    head1_b         : in    std_ulogic;
    head1_z         : in    std_ulogic;
    -- Calibration head, asynchronous
    head2_a         : in    std_ulogic;
    head2_b         : in    std_ulogic;
    head2_z         : in    std_ulogic;
    -- Further heads, asynchronous
    head3_a         : in    std_ulogic := '0';
    head3_b         : in    std_ulogic := '0';
    head3_z         : in    std_ulogic := '0';
    head4_a         : in    std_ulogic := '0';
    head4_b         : in    std_ulogic := '0';
    head4_z         : in    std_ulogic := '0';
    -- Corrected encoder signal
    out_a           : out   std_ulogic;
    out_b           : out   std_ulogic;
    out_z           : out   std_ulogic;
    driver_enable   : out   std_ulogic;                     -- enables the line drivers of A, B and Z
    alarm           : out   std_ulogic;                     -- high while a selected fault is present
    -- External instruments
    sync_in         : in    std_ulogic := '0';              -- asynchronous: an edge triggers a sample
    trigger_out     : out   std_ulogic;                     -- a pulse with each sample
    probe_in        : in    std_ulogic := '0';              -- asynchronous: an edge latches the corrected position
    compare_out     : out   std_ulogic;                     -- a pulse at chosen corrected positions
    -- The chip's identifier, if the top level reads it
    chip_dna        : in    std_ulogic_vector(56 downto 0) := (others => '0');
    chip_dna_known  : in    std_ulogic := '0';
    -- For status lamps
    status_capturing    : out   std_ulogic; -- high while a turn is being captured
    status_fault        : out   std_ulogic; -- high while a fault is present or not cleared
    status_compensating : out   std_ulogic  -- high while the output is corrected
  );
end entity arctrue_core;

architecture rtl of arctrue_core is

  subtype position_count is u_signed(POSITION_WIDTH - 1 downto 0);

  subtype angle_count is u_unsigned(ANGLE_WIDTH - 1 downto 0);

  subtype time_count is u_unsigned(TIMESTAMP_WIDTH - 1 downto 0);

  -- With HAS_MEAN the core corrects the mean of the heads. With more than two heads the mean takes an additional clock.
  constant HAS_MEAN     : boolean := MEAN or HEADS > 2;
  constant CORE_LATENCY : positive := PIPELINE_LATENCY + FOLD - 1 + boolean'pos(HEADS > 2);

  -- Address bits that distinguish turn steps from coefficients, and the turn number from turn steps.
  constant TURN_STEPS_BIT  : positive := 10;
  constant TURN_NUMBER_BIT : positive := 9;

  -- Address bit that distinguishes the local table's points from the words that define its windows.
  constant LOCAL_POINTS_BIT : positive := 16;

  constant IS_TABLE : boolean := ROTATION = "table";

  -- Number of faults in the register `alarm`; the faults of heads 3 and 4 are its highest bits.
  constant FAULT_KINDS : positive := 6 + 2 * boolean'pos(HEADS > 2);

  signal hwif_in  : arctrue_registers_in_t;
  signal hwif_out : arctrue_registers_out_t;

  -- Heads
  signal timestamp      : time_count := (others => '0');
  signal counts_per_rev : u_unsigned(COUNTS_PER_REV_WIDTH - 1 downto 0);
  signal rearm          : std_ulogic;
  signal changes_turn   : std_ulogic;
  signal pins           : std_ulogic_vector(1 to 3 * HEADS_MAX);
  signal pin_settings   : std_ulogic_vector(16 * HEADS_MAX - 1 downto 0);
  signal further_pins   : std_ulogic_vector(31 downto 0);
  signal head_delays    : std_ulogic_vector(31 downto 0);
  signal clear_head     : std_ulogic_vector(1 to HEADS_MAX);
  signal further_clear  : std_ulogic_vector(1 downto 0);
  signal rearm_heads    : std_ulogic_vector(1 to HEADS);
  signal decoded        : decoded_heads(1 to HEADS);

  -- The reading that is corrected, the writes to the idle banks, and the swap
  signal reading    : pipeline_reading;
  signal bank       : bank_update;
  signal may_swap   : std_ulogic;
  signal swap_comes : std_ulogic;
  signal swap_busy  : std_ulogic;
  signal swap_done  : std_ulogic;
  signal swap_count : u_unsigned(15 downto 0) := (others => '0');

  -- Capture
  signal captures           : std_ulogic;
  signal reference_position : position_count;
  signal reference_moved    : std_ulogic;
  signal further_samples    : std_ulogic_vector(2 * POSITION_WIDTH - 1 downto 0);
  signal further_flags      : std_ulogic_vector(7 downto 0);
  signal triggered          : std_ulogic;
  signal capture_ready      : std_ulogic;
  signal capture_overrun    : std_ulogic;
  signal capture_busy       : std_ulogic;
  signal bank_ready         : std_ulogic;
  signal start_time         : time_count;
  signal sequence_count     : u_unsigned(31 downto 0);
  signal sample_count       : u_unsigned(15 downto 0);
  signal header_flags       : std_ulogic_vector(9 downto 0);
  signal further_header     : std_ulogic_vector(7 downto 0);
  signal overrun_count      : u_unsigned(15 downto 0);
  signal fill_count         : u_unsigned(15 downto 0);

  -- Correction
  signal follow               : std_ulogic;
  signal corrected_angle      : angle_count;
  signal corrected_position   : position_count;
  signal corrected_referenced : std_ulogic;
  signal correction           : u_signed(CORRECTION_WIDTH - 1 downto 0);
  signal correction_limited   : std_ulogic;
  signal ramp_busy            : std_ulogic;
  signal ramp_busy_before     : std_ulogic := '0';
  signal following_error      : position_count;
  signal turn                 : u_signed(TURN_NUMBER_WIDTH - 1 downto 0);
  signal idle_offset          : u_signed(AMPLITUDE_WIDTH - 1 downto 0);
  signal local_word           : u_unsigned(LOCAL_INDEX_WIDTH - 1 downto 0);

  -- Conditions that multiply the amplitudes of lanes
  signal conditions_settled : std_ulogic;
  signal sweep_step         : u_unsigned(7 downto 0);
  signal direction          : modulator;
  signal speed              : modulator;
  signal idle_speed         : modulator;
  signal word_a             : modulator;
  signal word_b             : modulator;
  signal speed_squared      : modulator;

  -- Faults
  signal cannot_keep_up   : std_ulogic;
  signal processor_silent : std_ulogic;
  signal left_out         : std_ulogic_vector(1 to HEADS);
  signal parity_beyond    : std_ulogic;
  signal failover_changed : std_ulogic;
  signal faults           : std_ulogic_vector(7 downto 0);
  signal released         : std_ulogic;
  signal release_causes   : std_ulogic_vector(7 downto 0) := (others => '0');
  signal further_index    : std_ulogic_vector(3 to HEADS_MAX);

  -- External instruments
  signal sync_strobe   : std_ulogic;
  signal compare_armed : std_ulogic;
  signal probe_latched : std_ulogic;
  signal probe         : probe_edge;
  signal oldest_event  : queued_event;

  -- Words of the processor, see register_access
  signal access_address    : axi_lite_address;
  signal access_data       : std_ulogic_vector(31 downto 0);
  signal take_snapshot     : std_ulogic;
  signal capture_read      : std_ulogic;
  signal capture_valid     : std_ulogic;
  signal capture_data      : std_ulogic_vector(POSITION_WIDTH - 1 downto 0);
  signal coefficient_read  : std_ulogic;
  signal coefficient_write : std_ulogic;
  signal coefficient_done  : std_ulogic;
  signal coefficient_data  : std_ulogic_vector(31 downto 0);
  signal read_under_way    : std_ulogic_vector(1 downto 0) := (others => '0');
  signal write_acknowledge : std_ulogic;
  signal lane_written      : std_ulogic;
  signal offset_read       : std_ulogic;
  signal offset_write      : std_ulogic;
  signal offset_data       : std_ulogic_vector(31 downto 0);
  signal mean_read         : std_ulogic;
  signal mean_read_then    : std_ulogic := '0';
  signal mean_write        : std_ulogic;
  signal mean_written      : std_ulogic;
  signal mean_done         : std_ulogic;
  signal mean_data         : std_ulogic_vector(31 downto 0);
  signal heads_read        : std_ulogic;
  signal heads_write       : std_ulogic;
  signal heads_done        : std_ulogic;
  signal heads_data        : std_ulogic_vector(31 downto 0);
  signal sets_read         : std_ulogic;
  signal sets_write        : std_ulogic;
  signal sets_done         : std_ulogic;
  signal sets_data         : std_ulogic_vector(31 downto 0);
  signal conditions_read   : std_ulogic;
  signal conditions_write  : std_ulogic;
  signal conditions_done   : std_ulogic;
  signal conditions_data   : std_ulogic_vector(31 downto 0);
  signal local_read        : std_ulogic;
  signal local_write       : std_ulogic;
  signal local_done        : std_ulogic;
  signal local_data        : std_ulogic_vector(31 downto 0);
  signal turns_read        : std_ulogic;
  signal turns_under_way   : std_ulogic_vector(1 downto 0) := (others => '0');
  signal turns_write       : std_ulogic;
  signal turns_done        : std_ulogic;
  signal turns_data        : std_ulogic_vector(31 downto 0);

begin

  assert not FAILOVER or HEADS > 2
    report "arctrue_core: FAILOVER needs HEADS = 3 or 4; two heads have no mean without one of them"
    severity failure;

  -- Pins to positions ------------------------------------------------------------------------

  pins       <= head1_a & head1_b & head1_z & head2_a & head2_b & head2_z
                & head3_a & head3_b & head3_z & head4_a & head4_b & head4_z;
  clear_head <= hwif_out.command.clear_head1.value & hwif_out.command.clear_head2.value
                & further_clear(0) & further_clear(1);

  pin_settings <= further_pins
                  & hwif_out.head2_input.pins.filter_length.value & "0000"
                  & hwif_out.head2_input.pins.swap_ab.value & hwif_out.head2_input.pins.invert_z.value
                  & hwif_out.head2_input.pins.invert_b.value & hwif_out.head2_input.pins.invert_a.value
                  & hwif_out.head1_input.pins.filter_length.value & "0000"
                  & hwif_out.head1_input.pins.swap_ab.value & hwif_out.head1_input.pins.invert_z.value
                  & hwif_out.head1_input.pins.invert_b.value & hwif_out.head1_input.pins.invert_a.value;

  turn_length : entity work.rearm_control
    port map (
      clock          => clock,
      reset          => reset,
      rearm_command  => hwif_out.command.rearm.value,
      requested      => u_unsigned(hwif_out.counts_per_rev.value.value),
      counts_per_rev => counts_per_rev,
      rearm          => rearm,
      changes_turn   => changes_turn,
      refused        => hwif_in.status.counts_per_rev_refused.next_q
    );

  all_heads : entity work.encoder_heads
    generic map (
      HEADS => HEADS,
      MEAN  => HAS_MEAN
    )
    port map (
      clock                => clock,
      reset                => reset,
      pins                 => pins(1 to 3 * HEADS),
      timestamp            => timestamp,
      counts_per_rev       => counts_per_rev,
      pin_settings         => pin_settings(16 * HEADS - 1 downto 0),
      filter_length        => hwif_out.filter_length.value.value,
      delays               => head_delays(8 * HEADS - 1 downto 0),
      minimum_edge_spacing => u_unsigned(hwif_out.minimum_edge_spacing.value.value),
      index_tolerance      => u_unsigned(hwif_out.index_tolerance.value.value),
      zero_again           => hwif_out.lost_counts.zero_again.value,
      heal                 => hwif_out.lost_counts.heal.value,
      clear                => clear_head(1 to HEADS),
      rearm                => rearm or rearm_heads,
      decoded              => decoded
    );

  -- Positions to the reading that is corrected -----------------------------------------------

  mean_of_heads : if HAS_MEAN generate

    weighted : entity work.mean_unit
      generic map (
        LANES    => LANES,
        HEADS    => HEADS,
        FAILOVER => FAILOVER
      )
      port map (
        clock              => clock,
        reset              => reset,
        decoded            => decoded,
        counts_per_rev     => counts_per_rev,
        rearm              => rearm,
        compensate         => hwif_out.control.compensate.value,
        capture_enable     => hwif_out.control.capture_enable.value,
        swap               => hwif_out.command.swap.value,
        clear_output       => hwif_out.command.clear_output.value,
        take_snapshot      => take_snapshot,
        access_address     => access_address,
        access_data        => access_data,
        coefficient_write  => coefficient_write,
        offset_write       => offset_write,
        turns_write        => turns_write,
        mean_write         => mean_write,
        heads_read         => heads_read,
        heads_write        => heads_write,
        sets_read          => sets_read,
        sets_write         => sets_write,
        lane_written       => lane_written,
        mean_written       => mean_written,
        mean_data          => mean_data,
        heads_done         => heads_done,
        heads_data         => heads_data,
        sets_done          => sets_done,
        sets_data          => sets_data,
        bank               => bank,
        write_acknowledge  => write_acknowledge,
        swap_comes         => swap_comes,
        swap_busy          => swap_busy,
        may_swap           => may_swap,
        pins               => further_pins,
        delays             => head_delays,
        clear_heads        => further_clear,
        rearm_heads        => rearm_heads,
        reading            => reading,
        captures           => captures,
        reference_position => reference_position,
        reference_moved    => reference_moved,
        left_out           => left_out,
        parity_beyond      => parity_beyond,
        failover_changed   => failover_changed
      );

  else generate
    -- The position that is corrected and output contains the counts that were put back for lost counts.
    reading.angle         <= decoded(1).angle;
    reading.position      <= decoded(1).position + decoded(1).put_back;
    reading.phase_of_zero <= decoded(1).phase_of_zero - u_unsigned(decoded(1).put_back(1 downto 0));
    reading.put_back      <= decoded(1).put_back(15 downto 0);
    reading.zero_moved    <= decoded(1).zero_moved;
    reading.referenced    <= decoded(1).index_seen;
    reading.apply         <= hwif_out.control.compensate.value and decoded(1).index_seen;
    reading.mean_term     <= (others => '0');
    reading.mean_limited  <= '0';
    reading.jumped        <= '0';
    reading.jump          <= (others => '0');

    bank.lane      <= coefficient_write;
    bank.offset    <= offset_write;
    bank.turn_step <= turns_write;
    bank.mean      <= '0';
    bank.address   <= u_unsigned(access_address(9 downto 2));
    bank.data      <= access_data;
    bank.swap      <= hwif_out.command.swap.value;
    lane_written   <= write_acknowledge;
    may_swap       <= '1';

    mean_written  <= '0';
    mean_data     <= (others => '0');
    heads_done    <= '0';
    heads_data    <= (others => '0');
    sets_done     <= '0';
    sets_data     <= (others => '0');
    further_pins  <= (others => '0');
    further_clear <= "00";
    head_delays   <= (others => '0');

    rearm_heads        <= (others => '0');
    left_out           <= (others => '0');
    parity_beyond      <= '0';
    failover_changed   <= '0';
    captures           <= hwif_out.control.capture_enable.value;
    reference_position <= (others => '0');
    reference_moved    <= '0';
  end generate mean_of_heads;

  further_heads : for head in 3 to HEADS_MAX generate

    is_built : if head <= HEADS generate

      further_samples((head - 2) * POSITION_WIDTH - 1 downto (head - 3) * POSITION_WIDTH)
      <= std_ulogic_vector(decoded(head).turn_position);
      further_flags(head - 3) <= decoded(head).index_seen;
      further_flags(head - 1) <= decoded(head).index_error;
      further_flags(head + 1) <= decoded(head).illegal;
      further_flags(head + 3) <= decoded(head).overspeed;
    else generate
      further_samples((head - 2) * POSITION_WIDTH - 1 downto (head - 3) * POSITION_WIDTH) <= (others => '0');
      further_flags(head - 3) <= '0';
      further_flags(head - 1) <= '0';
      further_flags(head + 1) <= '0';
      further_flags(head + 3) <= '0';
    end generate is_built;

  end generate further_heads;

  -- Positions to the processor ---------------------------------------------------------------

  capture : entity work.sampler
    generic map (
      DEPTH => CAPTURE_DEPTH,
      HEADS => HEADS
    )
    port map (
      clock               => clock,
      reset               => reset,
      enable              => captures,
      mode                => u_unsigned(hwif_out.control.capture_mode.value),
      external            => sync_strobe,
      sample_period       => u_unsigned(hwif_out.sample_period.value.value),
      angle_step          => u_unsigned(hwif_out.angle_step.value.value),
      counts_per_rev      => counts_per_rev,
      timestamp           => timestamp,
      turn_position1      => decoded(1).turn_position,
      turn_position2      => decoded(2).turn_position,
      zero_moved1         => decoded(1).zero_moved,
      index_seen1         => decoded(1).index_seen,
      index_seen2         => decoded(2).index_seen,
      index_error1        => decoded(1).index_error,
      index_error2        => decoded(2).index_error,
      illegal1            => decoded(1).illegal,
      illegal2            => decoded(2).illegal,
      overspeed1          => decoded(1).overspeed,
      overspeed2          => decoded(2).overspeed,
      further_positions    => further_samples,
      further_flags        => further_flags,
      reference_position   => reference_position,
      reference_zero_moved => reference_moved,
      release_bank        => hwif_out.command.capture_release.value,
      capture_ready       => capture_ready,
      capture_overrun     => capture_overrun,
      capture_busy        => capture_busy,
      bank_ready          => bank_ready,
      ready_bank          => open,
      header_start_time   => start_time,
      header_sequence     => sequence_count,
      header_sample_count => sample_count,
      header_flags        => header_flags,
      header_further_flags => further_header,
      overrun_count       => overrun_count,
      fill_count          => fill_count,
      trigger             => triggered,
      read_enable         => capture_read,
      read_address        => u_unsigned(access_address(16 downto 2)),
      read_further        => access_address(18),
      read_valid          => capture_valid,
      read_data           => capture_data
    );

  -- Positions to corrected positions -----------------------------------------------------------

  local_word <= u_unsigned(access_address(LOCAL_INDEX_WIDTH + 1 downto 2)) when access_address(LOCAL_POINTS_BIT) = '1' else
                resize(u_unsigned(access_address(4 downto 2)), LOCAL_INDEX_WIDTH);

  follow <= hwif_out.control.output_enable.value and not changes_turn;

  compensation : entity work.compensation_pipeline
    generic map (
      LANES        => LANES,
      COSINE_WIDTH => COSINE_WIDTH,
      FOLD         => FOLD,
      MEAN         => HAS_MEAN,
      ROTATION     => ROTATION,
      MODULATORS   => MODULATORS,
      LOCAL_TABLE  => LOCAL_TABLE,
      REAL_ORDERS  => REAL_ORDERS
    )
    port map (
      clock              => clock,
      reset              => reset,
      accept             => open,
      angle              => reading.angle,
      position           => reading.position,
      apply              => reading.apply,
      zero_moved         => reading.zero_moved,
      put_back           => reading.put_back,
      referenced         => reading.referenced,
      mean_term          => reading.mean_term,
      jumped             => reading.jumped,
      jump               => reading.jump,
      counts_per_rev     => counts_per_rev,
      ramp_rate          => u_unsigned(hwif_out.ramp_rate.value.value),
      ramp_acceleration  => u_unsigned(hwif_out.ramp_acceleration.value.value),
      write_enable       => bank.lane,
      write_offset       => bank.offset,
      write_address      => bank.address,
      write_data         => bank.data,
      write_acknowledge  => write_acknowledge,
      read_address       => u_unsigned(access_address(9 downto 2)),
      read_data          => coefficient_data,
      idle_offset        => idle_offset,
      swap               => bank.swap,
      swap_allowed       => may_swap and conditions_settled,
      swap_comes         => swap_comes,
      swap_busy          => swap_busy,
      sweep_step         => sweep_step,
      direction          => direction,
      speed              => speed,
      idle_speed         => idle_speed,
      word_a             => word_a,
      word_b             => word_b,
      speed_squared      => speed_squared,
      write_turn_step    => bank.turn_step,
      read_turn_step     => access_address(TURN_STEPS_BIT),
      turn               => turn,
      local_read         => local_read,
      local_write        => local_write,
      local_of_place     => not access_address(LOCAL_POINTS_BIT),
      local_address      => local_word,
      local_data         => access_data,
      local_done         => local_done,
      local_answer       => local_data,
      corrected_angle    => corrected_angle,
      corrected_position => corrected_position,
      corrected_referenced => corrected_referenced,
      correction         => correction,
      correction_limited => correction_limited,
      ramp_busy          => ramp_busy,
      swap_done          => swap_done
    );

  modulated : if MODULATORS generate

    conditions : entity work.table_conditions
      port map (
        clock              => clock,
        reset              => reset,
        position           => reading.position,
        put_back           => reading.put_back,
        corrected_position => corrected_position,
        correction         => correction,
        read_enable        => conditions_read,
        write_enable       => conditions_write,
        address            => u_unsigned(access_address(5 downto 2)),
        write_data         => access_data,
        done               => conditions_done,
        read_data          => conditions_data,
        hold_writes        => bank.swap or swap_busy,
        swap_comes         => swap_comes,
        settled            => conditions_settled,
        sweep_step         => sweep_step,
        direction          => direction,
        speed              => speed,
        idle_speed         => idle_speed,
        word_a             => word_a,
        word_b             => word_b,
        speed_squared      => speed_squared
      );

  else generate
    conditions_done <= '0';
    conditions_data <= (others => '0');
    conditions_settled <= '1';
    sweep_step      <= (others => '0');
    direction       <= (others => '0');
    speed           <= (others => '0');
    idle_speed      <= (others => '0');
    word_a          <= (others => '0');
    word_b          <= (others => '0');
  end generate modulated;

  edges_out : entity work.quadrature_output
    port map (
      clock              => clock,
      reset              => reset,
      enable             => follow,
      clear              => hwif_out.command.clear_output.value,
      invert_a           => hwif_out.output_pins.invert_a.value,
      invert_b           => hwif_out.output_pins.invert_b.value,
      invert_z           => hwif_out.output_pins.invert_z.value,
      swap_ab            => hwif_out.output_pins.swap_ab.value,
      corrected_position => corrected_position,
      corrected_angle    => corrected_angle,
      referenced         => corrected_referenced,
      phase_of_zero      => reading.phase_of_zero,
      z_gated            => hwif_out.output_index.gated.value,
      z_state            => u_unsigned(hwif_out.output_index.state.value),
      z_width            => u_unsigned(hwif_out.output_index.width.value),
      counts_per_rev     => counts_per_rev,
      minimum_spacing    => u_unsigned(hwif_out.output_spacing.value.value),
      following_limit    => u_unsigned(hwif_out.following_limit.value.value),
      a                  => out_a,
      b                  => out_b,
      z                  => out_z,
      following_error    => following_error,
      cannot_keep_up     => cannot_keep_up
    );

  -- Alarms ------------------------------------------------------------------------------------

  calibrator_works : entity work.processor_watch
    port map (
      clock  => clock,
      reset  => reset,
      limit  => u_unsigned(hwif_out.processor_limit.value.value),
      alive  => hwif_out.command.alive.value,
      silent => processor_silent
    );

  faults(5 downto 0) <= decoded(1).swallowed & processor_silent & (correction_limited or reading.mean_limited or parity_beyond) & cannot_keep_up
            & (decoded(2).index_error or decoded(2).illegal or decoded(2).overspeed or left_out(2))
            & (decoded(1).index_error or decoded(1).illegal or decoded(1).overspeed or left_out(1));

  faults_of_further_heads : for number in 3 to HEADS_MAX generate

    decoded_here : if number <= HEADS generate

      faults(3 + number) <= decoded(number).index_error or decoded(number).illegal or decoded(number).overspeed or left_out(number);
      further_index(number) <= decoded(number).index_strobe;

    else generate

      faults(3 + number) <= '0';
      further_index(number) <= '0';

    end generate decoded_here;

  end generate faults_of_further_heads;

  reported_outside : entity work.fault_outputs
    generic map (
      KINDS => FAULT_KINDS
    )
    port map (
      clock           => clock,
      reset           => reset,
      enable          => hwif_out.control.output_enable.value,
      clear           => hwif_out.command.clear_output.value,
      present         => faults(FAULT_KINDS - 1 downto 0),
      alarm_sources   => hwif_out.alarm.sources.value(FAULT_KINDS - 1 downto 0),
      release_sources => hwif_out.alarm.released_by.value(FAULT_KINDS - 1 downto 0),
      released        => released,
      causes          => release_causes(FAULT_KINDS - 1 downto 0),
      driver_enable   => driver_enable,
      alarm           => alarm
    );

  -- External instruments ---------------------------------------------------------------

  instruments : entity work.instrument_signals
    generic map (
      CORE_LATENCY => CORE_LATENCY,
      EVENTS       => EVENTS
    )
    port map (
      clock          => clock,
      reset          => reset,
      timestamp      => timestamp,
      position       => corrected_position,
      angle          => corrected_angle,
      sampled        => triggered,
      sync_in        => sync_in,
      trigger_out    => trigger_out,
      probe_in       => probe_in,
      compare_out    => compare_out,
      sync_falling   => hwif_out.pulse_inputs.sync_falling.value,
      probe_falling  => hwif_out.pulse_inputs.probe_falling.value,
      filter_length  => u_unsigned(hwif_out.pulse_inputs.filter_length.value),
      trigger_width  => u_unsigned(hwif_out.pulse_widths.trigger.value),
      compare_width  => u_unsigned(hwif_out.pulse_widths.compare.value),
      first          => u_signed(hwif_out.compare.first.value.value),
      interval       => u_unsigned(hwif_out.compare.interval.value.value),
      recorded(0)    => hwif_out.events.recorded.probe.value,
      recorded(1)    => hwif_out.events.recorded.compare.value,
      compare_arm    => hwif_out.command.compare_arm.value,
      compare_disarm => hwif_out.command.compare_disarm.value,
      next_event     => hwif_out.command.next_event.value,
      sync_strobe    => sync_strobe,
      compare_armed  => compare_armed,
      probe_latched  => probe_latched,
      latched        => probe,
      oldest_event   => oldest_event
    );

  -- The processor's side -----------------------------------------------------------------------

  processor : entity work.register_access
    generic map (
      LANES         => LANES,
      CAPTURE_DEPTH => CAPTURE_DEPTH,
      HEADS         => HEADS,
      MEAN          => HAS_MEAN,
      MODULATORS    => MODULATORS,
      FAILOVER      => FAILOVER,
      LOCAL_TABLE   => LOCAL_TABLE,
      REAL_ORDERS   => REAL_ORDERS
    )
    port map (
      clock             => clock,
      reset             => reset,
      s_axil_request    => s_axil_request,
      s_axil_response   => s_axil_response,
      hwif_in           => hwif_in,
      hwif_out          => hwif_out,
      capture_ready     => bank_ready,
      access_address    => access_address,
      access_data       => access_data,
      coefficient_read  => coefficient_read,
      coefficient_write => coefficient_write,
      coefficient_data  => coefficient_data,
      offset_read       => offset_read,
      offset_write      => offset_write,
      offset_data       => offset_data,
      coefficient_done  => coefficient_done,
      mean_read         => mean_read,
      mean_write        => mean_write,
      mean_done         => mean_done,
      mean_data         => mean_data,
      heads_read        => heads_read,
      heads_write       => heads_write,
      heads_done        => heads_done,
      heads_data        => heads_data,
      sets_read         => sets_read,
      sets_write        => sets_write,
      sets_done         => sets_done,
      sets_data         => sets_data,
      conditions_read   => conditions_read,
      conditions_write  => conditions_write,
      conditions_done   => conditions_done,
      conditions_data   => conditions_data,
      local_read        => local_read,
      local_write       => local_write,
      local_done        => local_done,
      local_data        => local_data,
      turns_read        => turns_read,
      turns_write       => turns_write,
      turns_done        => turns_done,
      turns_data        => turns_data,
      take_snapshot     => take_snapshot,
      capture_read      => capture_read,
      capture_done      => capture_valid,
      capture_data      => capture_data
    );

  interrupt <= hwif_out.interrupt_status.intr;

  bookkeeping : process (clock) is
  begin

    if rising_edge(clock) then
      timestamp        <= timestamp + 1;
      swap_count       <= swap_count + ("" & swap_done);
      ramp_busy_before <= ramp_busy;

      -- The coefficient memory outputs a word two clocks after its address.
      read_under_way <= read_under_way(0) & coefficient_read;
      turns_under_way <= turns_under_way(0) & turns_read;
      mean_read_then <= mean_read;

      if reset = '1' then
        timestamp        <= (others => '0');
        swap_count       <= (others => '0');
        ramp_busy_before <= '0';
        read_under_way   <= (others => '0');
        turns_under_way  <= (others => '0');
        mean_read_then   <= '0';
      end if;
    end if;

  end process bookkeeping;

  offset_data      <= std_ulogic_vector(resize(idle_offset, 32));
  mean_done        <= mean_read_then or mean_written;
  coefficient_done <= read_under_way(1) or offset_read or lane_written;
  -- A written turn step is acknowledged like a coefficient.
  turns_done <= turns_under_way(1);
  turns_data <= std_ulogic_vector(resize(turn, 32)) when access_address(TURN_NUMBER_BIT) = '1' else
                coefficient_data;

  hwif_in.core_configuration.lanes.next_q         <= std_ulogic_vector(to_unsigned(LANES, 7));
  hwif_in.core_configuration.cosine_width.next_q  <= std_ulogic_vector(to_unsigned(COSINE_WIDTH, 5));
  hwif_in.core_configuration.capture_depth.next_q <= std_ulogic_vector(to_unsigned(CAPTURE_DEPTH, 15));
  hwif_in.pipeline.fold.next_q                    <= std_ulogic_vector(to_unsigned(FOLD, 4));
  hwif_in.pipeline.latency.next_q                 <= std_ulogic_vector(to_unsigned(CORE_LATENCY, 8));
  hwif_in.capability.heads.next_q                 <= std_ulogic_vector(to_unsigned(HEADS, 3));
  hwif_in.capability.mean.next_q                  <= '1' when HAS_MEAN else
                                                     '0';
  hwif_in.capability.rotation.next_q              <= '1' when IS_TABLE else
                                                     '0';
  hwif_in.capability.modulators.next_q            <= '1' when MODULATORS else
                                                     '0';
  hwif_in.capability.real_orders.next_q           <= '1' when REAL_ORDERS else
                                                     '0';
  hwif_in.capability.local_table.next_q           <= '1' when LOCAL_TABLE else
                                                     '0';
  hwif_in.capability.failover.next_q              <= '1' when FAILOVER else
                                                     '0';
  hwif_in.capability.events.next_q                <= '1' when EVENTS else
                                                     '0';
  hwif_in.chip_dna_low.value.next_q               <= chip_dna(31 downto 0);
  hwif_in.chip_dna_high.value.next_q              <= chip_dna(56 downto 32);
  hwif_in.chip_dna_high.known.next_q              <= chip_dna_known;
  hwif_in.clock_hz.value.next_q                   <= std_ulogic_vector(to_unsigned(CLOCK_HZ, 32));
  hwif_in.counts_per_rev_active.value.next_q      <= std_ulogic_vector(counts_per_rev);

  status_capturing    <= capture_busy;
  status_compensating <= reading.apply;
  status_fault        <= or faults;

  hwif_in.status.compensating.next_q   <= reading.apply;
  hwif_in.status.ramp_busy.next_q      <= ramp_busy;
  hwif_in.status.capture_ready.next_q  <= bank_ready;
  hwif_in.status.capture_busy.next_q   <= capture_busy;
  hwif_in.status.cannot_keep_up.next_q <= cannot_keep_up;
  hwif_in.status.processor_silent.next_q <= processor_silent;
  hwif_in.status.released.next_q         <= released;
  hwif_in.status.compare_armed.next_q    <= compare_armed;
  hwif_in.status.release_causes.next_q   <= release_causes;
  hwif_in.status.release_present.next_q  <= faults and hwif_out.alarm.released_by.value;

  hwif_in.probe.time.value.next_q     <= std_ulogic_vector(probe.time);
  hwif_in.probe.position.value.next_q <= probe.position;
  hwif_in.probe.angle.value.next_q    <= std_ulogic_vector(probe.angle);
  hwif_in.probe.edges.value.next_q    <= std_ulogic_vector(probe.number);

  hwif_in.events.state.kind.next_q            <= oldest_event.kind;
  hwif_in.events.state.waiting.next_q         <= std_ulogic_vector(oldest_event.waiting);
  hwif_in.events.state.sequence_number.next_q <= std_ulogic_vector(oldest_event.number);
  hwif_in.events.time_low.value.next_q        <= std_ulogic_vector(oldest_event.time(31 downto 0));
  hwif_in.events.time_high.value.next_q       <= std_ulogic_vector(oldest_event.time(63 downto 32));
  hwif_in.events.position.value.next_q        <= oldest_event.position;
  hwif_in.events.angle.value.next_q           <= std_ulogic_vector(oldest_event.angle);
  hwif_in.events.lost.value.next_q            <= std_ulogic_vector(oldest_event.lost);

  hwif_in.interrupt_status.probe.next_q <= probe_latched;
  hwif_in.swap_count.value.next_q      <= std_ulogic_vector(swap_count);
  hwif_in.overrun_count.value.next_q   <= std_ulogic_vector(overrun_count);
  hwif_in.zero.moves.next_q            <= std_ulogic_vector(decoded(1).zero_moves);
  hwif_in.zero_slip.value.next_q       <= resize(decoded(1).zero_slip, 32);
  hwif_in.put_back.value.next_q        <= decoded(1).put_back;
  hwif_in.capture_fill.value.next_q    <= std_ulogic_vector(fill_count);

  hwif_in.interrupt_status.capture_ready.next_q      <= capture_ready;
  hwif_in.interrupt_status.capture_overrun.next_q    <= capture_overrun;
  hwif_in.interrupt_status.head1_index.next_q        <= decoded(1).index_strobe;
  hwif_in.interrupt_status.head2_index.next_q        <= decoded(2).index_strobe;
  hwif_in.interrupt_status.head1_fault.next_q        <= faults(0);
  hwif_in.interrupt_status.head2_fault.next_q        <= faults(1);
  hwif_in.interrupt_status.head3_index.next_q        <= further_index(3);
  hwif_in.interrupt_status.head4_index.next_q        <= further_index(4);
  hwif_in.interrupt_status.head3_fault.next_q        <= faults(6);
  hwif_in.interrupt_status.head4_fault.next_q        <= faults(7);
  hwif_in.interrupt_status.failover.next_q           <= failover_changed;
  hwif_in.interrupt_status.swap_done.next_q          <= swap_done;
  hwif_in.interrupt_status.ramp_done.next_q          <= ramp_busy_before and not ramp_busy;
  hwif_in.interrupt_status.correction_limited.next_q <= correction_limited;
  hwif_in.interrupt_status.cannot_keep_up.next_q     <= cannot_keep_up;

  hwif_in.head1.flags.index_seen.next_q       <= decoded(1).index_seen;
  hwif_in.head1.flags.index_error.next_q      <= decoded(1).index_error;
  hwif_in.head1.flags.illegal.next_q          <= decoded(1).illegal;
  hwif_in.head1.flags.overspeed.next_q        <= decoded(1).overspeed;
  hwif_in.head1.flags.swallowed.next_q        <= decoded(1).swallowed;
  hwif_in.head1.flags.direction.next_q        <= decoded(1).direction;
  hwif_in.head1.flags.index_direction.next_q  <= decoded(1).index_direction;
  hwif_in.head1.faults.index_errors.next_q    <= std_ulogic_vector(decoded(1).index_error_count);
  hwif_in.head1.faults.illegals.next_q        <= std_ulogic_vector(decoded(1).illegal_count);
  hwif_in.head1.overspeeds.overspeeds.next_q  <= std_ulogic_vector(decoded(1).overspeed_count);
  hwif_in.head1.index.position.next_q         <= decoded(1).index_position;
  hwif_in.head1.index.interval.next_q         <= decoded(1).index_interval;

  hwif_in.head2.flags.index_seen.next_q       <= decoded(2).index_seen;
  hwif_in.head2.flags.index_error.next_q      <= decoded(2).index_error;
  hwif_in.head2.flags.illegal.next_q          <= decoded(2).illegal;
  hwif_in.head2.flags.overspeed.next_q        <= decoded(2).overspeed;
  hwif_in.head2.flags.swallowed.next_q        <= decoded(2).swallowed;
  hwif_in.head2.flags.direction.next_q        <= decoded(2).direction;
  hwif_in.head2.flags.index_direction.next_q  <= decoded(2).index_direction;
  hwif_in.head2.faults.index_errors.next_q    <= std_ulogic_vector(decoded(2).index_error_count);
  hwif_in.head2.faults.illegals.next_q        <= std_ulogic_vector(decoded(2).illegal_count);
  hwif_in.head2.overspeeds.overspeeds.next_q  <= std_ulogic_vector(decoded(2).overspeed_count);
  hwif_in.head2.index.position.next_q         <= decoded(2).index_position;
  hwif_in.head2.index.interval.next_q         <= decoded(2).index_interval;

  hwif_in.snapshot.time.value.next_q                <= std_ulogic_vector(timestamp);
  hwif_in.snapshot.head1_edge_time.value.next_q     <= std_ulogic_vector(decoded(1).last_edge_time);
  hwif_in.snapshot.head2_edge_time.value.next_q     <= std_ulogic_vector(decoded(2).last_edge_time);
  hwif_in.snapshot.head1_position.value.next_q      <= decoded(1).position;
  hwif_in.snapshot.head2_position.value.next_q      <= decoded(2).position;
  hwif_in.snapshot.head1_turn_position.value.next_q <= decoded(1).turn_position;
  hwif_in.snapshot.head2_turn_position.value.next_q <= decoded(2).turn_position;
  hwif_in.snapshot.head1_angle.value.next_q         <= std_ulogic_vector(decoded(1).angle);
  hwif_in.snapshot.head2_angle.value.next_q         <= std_ulogic_vector(decoded(2).angle);
  hwif_in.snapshot.corrected_position.value.next_q  <= corrected_position;
  hwif_in.snapshot.corrected_angle.value.next_q     <= std_ulogic_vector(corrected_angle);
  hwif_in.snapshot.correction.value.next_q          <= resize(correction, 32);
  hwif_in.snapshot.following_error.value.next_q     <= following_error;

  hwif_in.capture_header.start_time.value.next_q         <= std_ulogic_vector(start_time);
  hwif_in.capture_header.sequence_number.value.next_q    <= std_ulogic_vector(sequence_count);
  hwif_in.capture_header.sample_count.value.next_q       <= std_ulogic_vector(sample_count);
  hwif_in.capture_header.flags.index_seen1.next_q        <= header_flags(0);
  hwif_in.capture_header.flags.index_seen2.next_q        <= header_flags(1);
  hwif_in.capture_header.flags.index_error1.next_q       <= header_flags(2);
  hwif_in.capture_header.flags.index_error2.next_q       <= header_flags(3);
  hwif_in.capture_header.flags.illegal1.next_q           <= header_flags(4);
  hwif_in.capture_header.flags.illegal2.next_q           <= header_flags(5);
  hwif_in.capture_header.flags.overspeed1.next_q         <= header_flags(6);
  hwif_in.capture_header.flags.overspeed2.next_q         <= header_flags(7);
  hwif_in.capture_header.flags.overrun.next_q            <= header_flags(8);
  hwif_in.capture_header.flags.full_before_turn.next_q   <= header_flags(9);
  hwif_in.capture_header.flags.further_index_seen.next_q  <= further_header(1 downto 0);
  hwif_in.capture_header.flags.further_index_error.next_q <= further_header(3 downto 2);
  hwif_in.capture_header.flags.further_illegal.next_q     <= further_header(5 downto 4);
  hwif_in.capture_header.flags.further_overspeed.next_q   <= further_header(7 downto 6);

end architecture rtl;
