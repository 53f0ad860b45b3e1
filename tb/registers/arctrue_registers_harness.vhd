-- SPDX-License-Identifier: Apache-2.0
--
-- Flat ports around the register records of register_access and the generated block in it, so that a test bench can
-- drive every field (records are invisible to cocotb): a port a register, its bits where the map has
-- them. The coefficient window and the offset are plain memory, the capture window reads its own
-- word index twice; all three answer after `memory_latency` clocks.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.arctrue_registers_pkg.all;
  use work.axi_lite_pkg.all;

entity arctrue_registers_harness is
  generic (
    LANES         : positive := 4;
    CAPTURE_DEPTH : positive := 100;
    HEADS         : positive := 2;
    MEAN          : boolean  := false
  );
  port (
    clock                          : in    std_ulogic;
    reset                          : in    std_ulogic;
    s_axil_request                 : in    axi_lite_request;
    s_axil_response                : out   axi_lite_response;
    interrupt                      : out   std_ulogic;
    interrupt_events               : in    std_ulogic_vector(10 downto 0);
    memory_latency                 : in    u_unsigned(3 downto 0);
    core_configuration             : in    std_ulogic_vector(31 downto 0);
    pipeline                       : in    std_ulogic_vector(31 downto 0);
    capability                     : in    std_ulogic_vector(31 downto 0);
    chip_dna_low                   : in    std_ulogic_vector(31 downto 0);
    chip_dna_high                  : in    std_ulogic_vector(31 downto 0);
    clock_hz                       : in    std_ulogic_vector(31 downto 0);
    capability                     : in    std_ulogic_vector(31 downto 0);
    counts_per_rev_active          : in    std_ulogic_vector(31 downto 0);
    status                         : in    std_ulogic_vector(31 downto 0);
    swap_count                     : in    std_ulogic_vector(31 downto 0);
    overrun_count                  : in    std_ulogic_vector(31 downto 0);
    capture_fill                   : in    std_ulogic_vector(31 downto 0);
    head1_flags                    : in    std_ulogic_vector(31 downto 0);
    head1_faults                   : in    std_ulogic_vector(31 downto 0);
    head1_overspeeds               : in    std_ulogic_vector(31 downto 0);
    head1_index                    : in    std_ulogic_vector(63 downto 0);
    head2_flags                    : in    std_ulogic_vector(31 downto 0);
    head2_faults                   : in    std_ulogic_vector(31 downto 0);
    head2_overspeeds               : in    std_ulogic_vector(31 downto 0);
    head2_index                    : in    std_ulogic_vector(63 downto 0);
    zero                           : in    std_ulogic_vector(31 downto 0);
    probe_time                     : in    std_ulogic_vector(63 downto 0);
    probe_position                 : in    std_ulogic_vector(31 downto 0);
    probe_angle                    : in    std_ulogic_vector(31 downto 0);
    probe_edges                    : in    std_ulogic_vector(31 downto 0);
    zero_slip                      : in    std_ulogic_vector(31 downto 0);
    put_back                       : in    std_ulogic_vector(31 downto 0);
    snapshot_time                  : in    std_ulogic_vector(63 downto 0);
    snapshot_head1_edge_time       : in    std_ulogic_vector(63 downto 0);
    snapshot_head2_edge_time       : in    std_ulogic_vector(63 downto 0);
    snapshot_head1_position        : in    std_ulogic_vector(31 downto 0);
    snapshot_head2_position        : in    std_ulogic_vector(31 downto 0);
    snapshot_head1_turn_position   : in    std_ulogic_vector(31 downto 0);
    snapshot_head2_turn_position   : in    std_ulogic_vector(31 downto 0);
    snapshot_head1_angle           : in    std_ulogic_vector(31 downto 0);
    snapshot_head2_angle           : in    std_ulogic_vector(31 downto 0);
    snapshot_corrected_position    : in    std_ulogic_vector(31 downto 0);
    snapshot_corrected_angle       : in    std_ulogic_vector(31 downto 0);
    snapshot_correction            : in    std_ulogic_vector(31 downto 0);
    snapshot_following_error       : in    std_ulogic_vector(31 downto 0);
    capture_header_start_time      : in    std_ulogic_vector(63 downto 0);
    capture_header_sequence_number : in    std_ulogic_vector(31 downto 0);
    capture_header_sample_count    : in    std_ulogic_vector(31 downto 0);
    capture_header_flags           : in    std_ulogic_vector(31 downto 0);
    control                        : out   std_ulogic_vector(31 downto 0);
    command                        : out   std_ulogic_vector(31 downto 0);
    counts_per_rev                 : out   std_ulogic_vector(31 downto 0);
    filter_length                  : out   std_ulogic_vector(31 downto 0);
    minimum_edge_spacing           : out   std_ulogic_vector(31 downto 0);
    sample_period                  : out   std_ulogic_vector(31 downto 0);
    angle_step                     : out   std_ulogic_vector(31 downto 0);
    ramp_rate                      : out   std_ulogic_vector(31 downto 0);
    output_spacing                 : out   std_ulogic_vector(31 downto 0);
    following_limit                : out   std_ulogic_vector(31 downto 0);
    index_tolerance                : out   std_ulogic_vector(31 downto 0);
    output_index                   : out   std_ulogic_vector(31 downto 0);
    lost_counts                    : out   std_ulogic_vector(31 downto 0);
    processor_limit                : out   std_ulogic_vector(31 downto 0);
    ramp_acceleration              : out   std_ulogic_vector(31 downto 0);
    head1_input                    : out   std_ulogic_vector(31 downto 0);
    head2_input                    : out   std_ulogic_vector(31 downto 0);
    output_pins                    : out   std_ulogic_vector(31 downto 0);
    alarm                          : out   std_ulogic_vector(31 downto 0);
    pulse_widths                   : out   std_ulogic_vector(31 downto 0);
    pulse_inputs                   : out   std_ulogic_vector(31 downto 0);
    compare_first                  : out   std_ulogic_vector(31 downto 0);
    compare_interval               : out   std_ulogic_vector(31 downto 0)
  );
end entity arctrue_registers_harness;

architecture simulation of arctrue_registers_harness is

  type words is array (natural range <>) of std_ulogic_vector(31 downto 0);

  signal hwif_in  : arctrue_registers_in_t;
  signal hwif_out : arctrue_registers_out_t;

  signal access_address    : axi_lite_address;
  signal access_data       : std_ulogic_vector(31 downto 0);
  signal coefficient_read  : std_ulogic;
  signal coefficient_write : std_ulogic;
  signal coefficient_done  : std_ulogic := '0';
  signal coefficient_data  : std_ulogic_vector(31 downto 0);
  signal offset_read       : std_ulogic;
  signal offset_write      : std_ulogic;
  signal offset_data       : std_ulogic_vector(31 downto 0);
  signal mean_read         : std_ulogic;
  signal mean_write        : std_ulogic;
  signal mean_done         : std_ulogic := '0';
  signal mean_data         : std_ulogic_vector(31 downto 0);
  signal capture_read      : std_ulogic;
  signal capture_done      : std_ulogic := '0';
  signal capture_data      : std_ulogic_vector(31 downto 0);

  function padded (
    value : std_ulogic_vector
  ) return std_ulogic_vector is
  begin

    return std_ulogic_vector(resize(u_unsigned(value), 32));

  end function padded;

begin

  processor : entity work.register_access
    generic map (
      LANES         => LANES,
      CAPTURE_DEPTH => CAPTURE_DEPTH,
      HEADS         => HEADS,
      MEAN          => MEAN
    )
    port map (
      clock             => clock,
      reset             => reset,
      s_axil_request    => s_axil_request,
      s_axil_response   => s_axil_response,
      hwif_in           => hwif_in,
      hwif_out          => hwif_out,
      capture_ready     => status(2),
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
      capture_read      => capture_read,
      capture_done      => capture_done,
      capture_data      => capture_data
    );

  interrupt <= hwif_out.interrupt_status.intr;

  hwif_in.interrupt_status.capture_ready.next_q <= interrupt_events(0);
  hwif_in.interrupt_status.capture_overrun.next_q <= interrupt_events(1);
  hwif_in.interrupt_status.head1_index.next_q <= interrupt_events(2);
  hwif_in.interrupt_status.head2_index.next_q <= interrupt_events(3);
  hwif_in.interrupt_status.head1_fault.next_q <= interrupt_events(4);
  hwif_in.interrupt_status.head2_fault.next_q <= interrupt_events(5);
  hwif_in.interrupt_status.swap_done.next_q <= interrupt_events(6);
  hwif_in.interrupt_status.ramp_done.next_q <= interrupt_events(7);
  hwif_in.interrupt_status.correction_limited.next_q <= interrupt_events(8);
  hwif_in.interrupt_status.cannot_keep_up.next_q <= interrupt_events(9);

  hwif_in.core_configuration.lanes.next_q <= core_configuration(6 downto 0);
  hwif_in.core_configuration.cosine_width.next_q <= core_configuration(12 downto 8);
  hwif_in.core_configuration.capture_depth.next_q <= core_configuration(30 downto 16);
  hwif_in.pipeline.fold.next_q <= pipeline(3 downto 0);
  hwif_in.pipeline.latency.next_q <= pipeline(15 downto 8);
  hwif_in.chip_dna_low.value.next_q <= chip_dna_low;
  hwif_in.chip_dna_high.value.next_q <= chip_dna_high(24 downto 0);
  hwif_in.chip_dna_high.known.next_q <= chip_dna_high(31);
  hwif_in.capability.heads.next_q <= capability(2 downto 0);
  hwif_in.capability.mean.next_q <= capability(3);
  hwif_in.clock_hz.value.next_q <= clock_hz;
  hwif_in.capability.heads.next_q <= capability(2 downto 0);
  hwif_in.capability.rotation.next_q <= capability(4);
  hwif_in.counts_per_rev_active.value.next_q <= counts_per_rev_active(24 downto 0);
  hwif_in.status.compensating.next_q <= status(0);
  hwif_in.status.ramp_busy.next_q <= status(1);
  hwif_in.status.capture_ready.next_q <= status(2);
  hwif_in.status.capture_busy.next_q <= status(3);
  hwif_in.status.cannot_keep_up.next_q <= status(4);
  hwif_in.status.counts_per_rev_refused.next_q <= status(5);
  hwif_in.status.processor_silent.next_q <= status(6);
  hwif_in.status.released.next_q <= status(7);
  hwif_in.status.compare_armed.next_q <= status(8);
  hwif_in.status.release_causes.next_q <= status(21 downto 16);
  hwif_in.status.release_present.next_q <= status(29 downto 24);
  hwif_in.interrupt_status.probe.next_q <= interrupt_events(10);
  hwif_in.probe.time.value.next_q <= probe_time;
  hwif_in.probe.position.value.next_q <= u_signed(probe_position);
  hwif_in.probe.angle.value.next_q <= probe_angle(23 downto 0);
  hwif_in.probe.edges.value.next_q <= probe_edges(15 downto 0);
  hwif_in.swap_count.value.next_q <= swap_count(15 downto 0);
  hwif_in.overrun_count.value.next_q <= overrun_count(15 downto 0);
  hwif_in.capture_fill.value.next_q <= capture_fill(15 downto 0);
  hwif_in.zero.moves.next_q <= zero(15 downto 0);
  hwif_in.zero_slip.value.next_q <= u_signed(zero_slip);
  hwif_in.put_back.value.next_q <= u_signed(put_back);
  hwif_in.head1.flags.index_seen.next_q <= head1_flags(0);
  hwif_in.head1.flags.index_error.next_q <= head1_flags(1);
  hwif_in.head1.flags.illegal.next_q <= head1_flags(2);
  hwif_in.head1.flags.overspeed.next_q <= head1_flags(3);
  hwif_in.head1.flags.direction.next_q <= head1_flags(4);
  hwif_in.head1.flags.index_direction.next_q <= head1_flags(5);
  hwif_in.head1.flags.swallowed.next_q <= head1_flags(6);
  hwif_in.head1.faults.index_errors.next_q <= head1_faults(15 downto 0);
  hwif_in.head1.faults.illegals.next_q <= head1_faults(31 downto 16);
  hwif_in.head1.overspeeds.overspeeds.next_q <= head1_overspeeds(15 downto 0);
  hwif_in.head1.index.position.next_q <= u_signed(head1_index(31 downto 0));
  hwif_in.head1.index.interval.next_q <= u_signed(head1_index(63 downto 32));
  hwif_in.head2.flags.index_seen.next_q <= head2_flags(0);
  hwif_in.head2.flags.index_error.next_q <= head2_flags(1);
  hwif_in.head2.flags.illegal.next_q <= head2_flags(2);
  hwif_in.head2.flags.overspeed.next_q <= head2_flags(3);
  hwif_in.head2.flags.direction.next_q <= head2_flags(4);
  hwif_in.head2.flags.index_direction.next_q <= head2_flags(5);
  hwif_in.head2.flags.swallowed.next_q <= head2_flags(6);
  hwif_in.head2.faults.index_errors.next_q <= head2_faults(15 downto 0);
  hwif_in.head2.faults.illegals.next_q <= head2_faults(31 downto 16);
  hwif_in.head2.overspeeds.overspeeds.next_q <= head2_overspeeds(15 downto 0);
  hwif_in.head2.index.position.next_q <= u_signed(head2_index(31 downto 0));
  hwif_in.head2.index.interval.next_q <= u_signed(head2_index(63 downto 32));
  hwif_in.snapshot.time.value.next_q <= snapshot_time;
  hwif_in.snapshot.head1_edge_time.value.next_q <= snapshot_head1_edge_time;
  hwif_in.snapshot.head2_edge_time.value.next_q <= snapshot_head2_edge_time;
  hwif_in.snapshot.head1_position.value.next_q <= u_signed(snapshot_head1_position);
  hwif_in.snapshot.head2_position.value.next_q <= u_signed(snapshot_head2_position);
  hwif_in.snapshot.head1_turn_position.value.next_q <= u_signed(snapshot_head1_turn_position);
  hwif_in.snapshot.head2_turn_position.value.next_q <= u_signed(snapshot_head2_turn_position);
  hwif_in.snapshot.head1_angle.value.next_q <= snapshot_head1_angle(23 downto 0);
  hwif_in.snapshot.head2_angle.value.next_q <= snapshot_head2_angle(23 downto 0);
  hwif_in.snapshot.corrected_position.value.next_q <= u_signed(snapshot_corrected_position);
  hwif_in.snapshot.corrected_angle.value.next_q <= snapshot_corrected_angle(23 downto 0);
  hwif_in.snapshot.correction.value.next_q <= u_signed(snapshot_correction);
  hwif_in.snapshot.following_error.value.next_q <= u_signed(snapshot_following_error);
  hwif_in.capture_header.start_time.value.next_q <= capture_header_start_time;
  hwif_in.capture_header.sequence_number.value.next_q <= capture_header_sequence_number;
  hwif_in.capture_header.sample_count.value.next_q <= capture_header_sample_count(15 downto 0);
  hwif_in.capture_header.flags.index_seen1.next_q <= capture_header_flags(0);
  hwif_in.capture_header.flags.index_seen2.next_q <= capture_header_flags(1);
  hwif_in.capture_header.flags.index_error1.next_q <= capture_header_flags(2);
  hwif_in.capture_header.flags.index_error2.next_q <= capture_header_flags(3);
  hwif_in.capture_header.flags.illegal1.next_q <= capture_header_flags(4);
  hwif_in.capture_header.flags.illegal2.next_q <= capture_header_flags(5);
  hwif_in.capture_header.flags.overspeed1.next_q <= capture_header_flags(6);
  hwif_in.capture_header.flags.overspeed2.next_q <= capture_header_flags(7);
  hwif_in.capture_header.flags.overrun.next_q <= capture_header_flags(8);
  hwif_in.capture_header.flags.full_before_turn.next_q <= capture_header_flags(9);
  hwif_in.capture_header.flags.further_index_seen.next_q <= capture_header_flags(11 downto 10);
  hwif_in.capture_header.flags.further_index_error.next_q <= capture_header_flags(13 downto 12);
  hwif_in.capture_header.flags.further_illegal.next_q <= capture_header_flags(15 downto 14);
  hwif_in.capture_header.flags.further_overspeed.next_q <= capture_header_flags(17 downto 16);

  control <= padded(std_ulogic_vector'(
      hwif_out.control.capture_mode.value &
      hwif_out.control.capture_enable.value &
      hwif_out.control.output_enable.value &
      hwif_out.control.compensate.value));
  command <= padded(std_ulogic_vector'(
      hwif_out.command.compare_disarm.value &
      hwif_out.command.compare_arm.value &
      hwif_out.command.alive.value &
      hwif_out.command.rearm.value &
      hwif_out.command.clear_output.value &
      hwif_out.command.clear_head2.value &
      hwif_out.command.clear_head1.value &
      hwif_out.command.capture_release.value &
      hwif_out.command.swap.value));
  counts_per_rev <= hwif_out.counts_per_rev.value.value;
  filter_length <= padded(hwif_out.filter_length.value.value);
  minimum_edge_spacing <= padded(hwif_out.minimum_edge_spacing.value.value);
  sample_period <= hwif_out.sample_period.value.value;
  angle_step <= padded(hwif_out.angle_step.value.value);
  ramp_rate <= hwif_out.ramp_rate.value.value;
  output_spacing <= padded(hwif_out.output_spacing.value.value);
  following_limit <= padded(hwif_out.following_limit.value.value);
  index_tolerance <= padded(hwif_out.index_tolerance.value.value);
  lost_counts <= (0 => hwif_out.lost_counts.zero_again.value, 1 => hwif_out.lost_counts.heal.value, others => '0');
  head1_input <= padded(
    hwif_out.head1_input.pins.filter_length.value & "0000" & hwif_out.head1_input.pins.swap_ab.value
    & hwif_out.head1_input.pins.invert_z.value & hwif_out.head1_input.pins.invert_b.value
    & hwif_out.head1_input.pins.invert_a.value
  );
  head2_input <= padded(
    hwif_out.head2_input.pins.filter_length.value & "0000" & hwif_out.head2_input.pins.swap_ab.value
    & hwif_out.head2_input.pins.invert_z.value & hwif_out.head2_input.pins.invert_b.value
    & hwif_out.head2_input.pins.invert_a.value
  );
  output_pins <= padded(std_ulogic_vector'(
      hwif_out.output_pins.swap_ab.value &
      hwif_out.output_pins.invert_z.value &
      hwif_out.output_pins.invert_b.value &
      hwif_out.output_pins.invert_a.value));
  alarm            <= padded(hwif_out.alarm.released_by.value & "00" & hwif_out.alarm.sources.value);
  pulse_widths     <= hwif_out.pulse_widths.compare.value & hwif_out.pulse_widths.trigger.value;
  pulse_inputs     <= padded(
    hwif_out.pulse_inputs.filter_length.value & "000000" & hwif_out.pulse_inputs.probe_falling.value
    & hwif_out.pulse_inputs.sync_falling.value
  );
  compare_first    <= std_ulogic_vector(hwif_out.compare.first.value.value);
  compare_interval <= padded(hwif_out.compare.interval.value.value);
  ramp_acceleration <= hwif_out.ramp_acceleration.value.value;
  processor_limit <= hwif_out.processor_limit.value.value;
  output_index <= padded(
    hwif_out.output_index.width.value & "00" & hwif_out.output_index.state.value & "000" & hwif_out.output_index.gated.value
  );

  memories : process (clock) is

    variable coefficients : words(0 to 255)               := (others => (others => '0'));
    variable offset       : std_ulogic_vector(31 downto 0) := (others => '0');
    variable waiting      : natural range 0 to 15          := 0;
    variable word         : natural range 0 to 32767       := 0;
    variable mean_words   : words(0 to 15)                 := (others => (others => '0'));
    variable window       : std_ulogic_vector(3 downto 0)  := "0000";
    variable answer       : std_ulogic_vector(3 downto 0);

  begin

    if rising_edge(clock) then
      answer := "0000";
      if waiting = 1 then
        answer := window;
      end if;
      if waiting /= 0 then
        waiting := waiting - 1;
      end if;

      if (coefficient_read or coefficient_write or offset_read or offset_write or mean_read or mean_write or capture_read) = '1' then
        assert waiting = 0
          report "a request before the answer to the last one"
          severity failure;
        waiting  := to_integer(memory_latency);
        window   := (mean_read or mean_write) & capture_read & (offset_read or offset_write) & (coefficient_read or coefficient_write);
        word     := to_integer(u_unsigned(access_address(16 downto 2)));
        if window(0) = '1' then
          word := to_integer(u_unsigned(access_address(9 downto 2)));
        end if;
        if coefficient_write = '1' then
          coefficients(word) := access_data;
        elsif offset_write = '1' then
          offset := access_data;
        elsif mean_write = '1' then
          mean_words(word mod 16) := access_data;
        end if;
      end if;

      coefficient_done <= answer(0) or answer(1);
      coefficient_data <= coefficients(word mod 256);
      offset_data      <= offset;
      mean_done        <= answer(3);
      mean_data        <= mean_words(word mod 16);
      capture_done     <= answer(2);
      capture_data     <= not std_ulogic_vector(to_unsigned(word, 16)) & std_ulogic_vector(to_unsigned(word, 16));
    end if;

  end process memories;

end architecture simulation;
