-- SPDX-License-Identifier: Apache-2.0
--
-- # mean_unit
--
-- Outputs the reading that the core corrects: the carrier's reading, and the term that turns it into the weighted mean
-- of the decoded heads (head_mean). It also contains the registers of heads 3 and 4 (head_registers) and, with
-- FAILOVER, the units that leave a failed head out of the mean (prepared_sets, head_failover).
--
-- **Latency.** As head_mean: the reading follows the heads by 0 clocks with two heads, and by 1 clock with more heads.
-- With FAILOVER, `bank` follows the processor's writes as the header of prepared_sets states; without it, in the same
-- clock.
--
-- **Number formats.** mean_pkg and decoder_pkg state those of the records; the register map states all other formats.
-- `pins` carries head 3 in the low bits, `clear_heads` head 3 in bit 0, and `delays` head 1 in the low bits.
--
-- **Capture.** The sampler captures turns of the carrier (with two heads, turns of head 1), and only while every used
-- head has seen its index. A change of the carrier drops the unfinished turn. `captures` follows these conditions by 1
-- clock.
--
-- **Words.** `bank` carries the processor's writes to the words of lanes and mean, and with FAILOVER also those of the
-- prepared sets. `lane_written` acknowledges the processor's writes to lanes, offset and turn steps, `mean_written`
-- those to the mean.
--
-- **Reset** acts as in the units. `captures` and the number of the previous carrier have no reset.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.axi_lite_pkg.all;
  use work.decoder_pkg.all;
  use work.mean_pkg.all;
  use work.number_formats_pkg.all;

entity mean_unit is
  generic (
    LANES    : positive range 1 to LANES_MAX := LANES_DEFAULT; -- number of harmonic lanes
    HEADS    : positive range 2 to HEADS_MAX := 2;
    FAILOVER : boolean                       := false          -- a failed head of three or four can be left out of the mean
  );
  port (
    clock              : in    std_ulogic;
    reset              : in    std_ulogic;
    decoded            : in    decoded_heads(1 to HEADS);
    counts_per_rev     : in    u_unsigned(COUNTS_PER_REV_WIDTH - 1 downto 0);       -- counts
    rearm              : in    std_ulogic;                                          -- level: the heads are held at angle zero
    -- Settings and commands
    compensate         : in    std_ulogic;                                          -- level: the processor requests the correction
    capture_enable     : in    std_ulogic;                                          -- level: the processor requests captures
    swap               : in    std_ulogic;                                          -- pulse: the idle banks become active
    clear_output       : in    std_ulogic;                                          -- pulse: clears the sticky flags of mean and failover
    take_snapshot      : in    std_ulogic;                                          -- pulse: latch the values of heads 3 and 4
    -- Words of the processor, see register_access
    access_address     : in    axi_lite_address;                                    -- bytes
    access_data        : in    std_ulogic_vector(31 downto 0);                      -- word to be written
    coefficient_write  : in    std_ulogic;                                          -- pulse
    offset_write       : in    std_ulogic;                                          -- pulse
    turns_write        : in    std_ulogic;                                          -- pulse
    mean_write         : in    std_ulogic;                                          -- pulse
    heads_read         : in    std_ulogic;                                          -- pulse
    heads_write        : in    std_ulogic;                                          -- pulse
    sets_read          : in    std_ulogic;                                          -- pulse
    sets_write         : in    std_ulogic;                                          -- pulse
    lane_written       : out   std_ulogic;                                          -- pulse: a lane, the offset or a turn step is written
    mean_written       : out   std_ulogic;                                          -- pulse: the word is written
    mean_data          : out   std_ulogic_vector(31 downto 0);                      -- the idle word, one clock after its address
    heads_done         : out   std_ulogic;                                          -- pulse: the word is read or written
    heads_data         : out   std_ulogic_vector(31 downto 0);                      -- the word
    sets_done          : out   std_ulogic;                                          -- pulse: the word is read or written
    sets_data          : out   std_ulogic_vector(31 downto 0);                      -- the word
    -- The banks
    bank               : out   bank_update;
    write_acknowledge  : in    std_ulogic;                                          -- pulse: coefficient_memory has written a word
    swap_comes         : in    std_ulogic;                                          -- pulse: the next angle is the first of the new banks
    swap_busy          : in    std_ulogic;                                          -- level: a swap waits, or the idle bank is being filled
    may_swap           : out   std_ulogic;                                          -- level: a swap is allowed
    -- Settings and commands of the heads
    pins               : out   std_ulogic_vector(31 downto 0);                      -- 16 bits per head, heads 3 and 4
    delays             : out   std_ulogic_vector(31 downto 0);                      -- clocks, 8 bits per head
    clear_heads        : out   std_ulogic_vector(1 downto 0);                       -- pulses: clear the faults of head 3, of head 4
    rearm_heads        : out   std_ulogic_vector(1 to HEADS);                       -- level: the head's index is cleared
    -- To the pipeline
    reading            : out   pipeline_reading;
    -- To the sampler
    captures           : out   std_ulogic;                                          -- level: the sampler captures
    reference_position : out   u_signed(POSITION_WIDTH - 1 downto 0);               -- counts from the zero of the carrier
    reference_moved    : out   std_ulogic;                                          -- toggles when the zero of the carrier moves
    -- Faults
    left_out           : out   std_ulogic_vector(1 to HEADS);                       -- level: the head is left out of the mean
    parity_beyond      : out   std_ulogic;                                          -- sticky: the parity of the heads exceeds its limit
    failover_changed   : out   std_ulogic                                           -- pulse: a set was loaded, or a head came back
  );
end entity mean_unit;

architecture rtl of mean_unit is

  signal angles            : std_ulogic_vector(HEADS * ANGLE_WIDTH - 1 downto 0);
  signal positions         : std_ulogic_vector(HEADS * POSITION_WIDTH - 1 downto 0);
  signal phases            : std_ulogic_vector(HEADS * 2 - 1 downto 0);
  signal put_backs         : std_ulogic_vector(HEADS * 16 - 1 downto 0);
  signal zeros_moved       : std_ulogic_vector(HEADS - 1 downto 0);
  signal indices_seen      : std_ulogic_vector(HEADS - 1 downto 0);
  signal carrier           : u_unsigned(1 downto 0);
  signal carrier_then      : u_unsigned(1 downto 0) := "00";
  signal hold_writes       : std_ulogic;
  signal used_seen         : std_ulogic;
  signal used              : std_ulogic_vector(HEADS - 1 downto 0);
  signal idle_used         : std_ulogic_vector(HEADS - 1 downto 0);
  signal idle_carrier_used : std_ulogic;
  signal differences       : std_ulogic_vector(HEADS * HEAD_DIFFERENCE_WIDTH - 1 downto 0);
  signal mean_acknowledged : std_ulogic;
  signal heads_answer      : std_ulogic_vector(31 downto 0);
  signal failover_answer   : std_ulogic_vector(31 downto 0);

begin

  -- The position that is corrected and output contains the counts that were put back for lost counts.
  every_head : for head in 0 to HEADS - 1 generate

    alias it : decoded_head is decoded(head + 1);

  begin

    angles((head + 1) * ANGLE_WIDTH - 1 downto head * ANGLE_WIDTH)          <= std_ulogic_vector(it.angle);
    positions((head + 1) * POSITION_WIDTH - 1 downto head * POSITION_WIDTH) <= std_ulogic_vector(it.position + it.put_back);
    phases(2 * head + 1 downto 2 * head)       <= std_ulogic_vector(it.phase_of_zero - u_unsigned(it.put_back(1 downto 0)));
    put_backs(16 * head + 15 downto 16 * head) <= std_ulogic_vector(it.put_back(15 downto 0));
    zeros_moved(head)                          <= it.zero_moved;
    indices_seen(head)                         <= it.index_seen;

  end generate every_head;

  hold_writes <= bank.swap or swap_busy;

  mean : entity work.head_mean
    generic map (
      HEADS => HEADS
    )
    port map (
      clock             => clock,
      reset             => reset,
      angles            => angles,
      positions         => positions,
      phases_of_zero    => phases,
      put_backs         => put_backs,
      zeros_moved       => zeros_moved,
      indices_seen      => indices_seen,
      unsettle          => rearm,
      counts_per_rev    => counts_per_rev,
      compensate        => compensate,
      write_enable      => bank.mean,
      write_address     => bank.address(3 downto 0),
      write_data        => bank.data,
      write_acknowledge => mean_acknowledged,
      hold_writes       => hold_writes,
      read_address      => u_unsigned(access_address(5 downto 2)),
      read_data         => mean_data,
      swap_comes        => swap_comes,
      may_swap          => may_swap,
      angle             => reading.angle,
      position          => reading.position,
      phase_of_zero     => reading.phase_of_zero,
      put_back          => reading.put_back,
      zero_moved        => reading.zero_moved,
      referenced        => reading.referenced,
      apply             => reading.apply,
      carrier           => carrier,
      used              => used,
      idle_used         => idle_used,
      idle_carrier_used => idle_carrier_used,
      differences       => differences,
      mean_term         => reading.mean_term,
      limited           => reading.mean_limited,
      jumped            => reading.jumped,
      jump              => reading.jump
    );

  further_registers : entity work.head_registers
    port map (
      clock              => clock,
      reset              => reset,
      read_enable        => heads_read,
      write_enable       => heads_write,
      address            => u_unsigned(access_address(7 downto 2)),
      write_data         => access_data,
      done               => heads_done,
      read_data          => heads_answer,
      take_snapshot      => take_snapshot,
      head3              => decoded(minimum(3, HEADS)),
      head4              => decoded(minimum(4, HEADS)),
      indices_seen       => std_ulogic_vector(resize(u_unsigned(indices_seen), 4)),
      difference_limited => reading.mean_limited,
      clear_limited      => clear_output,
      pins               => pins,
      clear_heads        => clear_heads,
      delays             => delays
    );

  heads_data <= heads_answer or failover_answer;

  used_seen <= and (indices_seen or not used);

  choose_reference : process (clock) is
  begin

    if rising_edge(clock) then
      carrier_then <= carrier;
      captures     <= capture_enable and used_seen and not (or (carrier xor carrier_then));
    end if;

  end process choose_reference;

  reference_position <= decoded(to_integer(carrier) + 1).turn_position;
  reference_moved    <= decoded(to_integer(carrier) + 1).zero_moved;

  leaves_out : if FAILOVER generate

    signal steps              : std_ulogic_vector(HEADS - 1 downto 0);
    signal steps_up           : std_ulogic_vector(HEADS - 1 downto 0);
    signal illegals           : std_ulogic_vector(HEADS - 1 downto 0);
    signal illegal_counts     : std_ulogic_vector(HEADS - 1 downto 0);
    signal overspeeds         : std_ulogic_vector(HEADS - 1 downto 0);
    signal overspeed_counts   : std_ulogic_vector(HEADS - 1 downto 0);
    signal swallowed          : std_ulogic_vector(HEADS - 1 downto 0);
    signal index_errors       : std_ulogic_vector(HEADS - 1 downto 0);
    signal index_error_counts : std_ulogic_vector(HEADS - 1 downto 0);
    signal rearmed            : std_ulogic_vector(HEADS - 1 downto 0);
    signal missing            : std_ulogic_vector(HEADS - 1 downto 0);
    signal acknowledged       : std_ulogic;
    signal load_set           : std_ulogic;
    signal set_number         : u_unsigned(2 downto 0);
    signal set_busy           : std_ulogic;
    signal set_loaded         : std_ulogic;
    signal may_activate       : std_ulogic;
    signal swap_refused       : std_ulogic;

  begin

    every_decoder : for head in 0 to HEADS - 1 generate

      steps(head)              <= decoded(head + 1).step;
      steps_up(head)           <= decoded(head + 1).step_up;
      illegals(head)           <= decoded(head + 1).illegal;
      illegal_counts(head)     <= decoded(head + 1).illegal_count(0);
      overspeeds(head)         <= decoded(head + 1).overspeed;
      overspeed_counts(head)   <= decoded(head + 1).overspeed_count(0);
      swallowed(head)          <= decoded(head + 1).swallowed;
      index_errors(head)       <= decoded(head + 1).index_error;
      index_error_counts(head) <= decoded(head + 1).index_error_count(0);
      rearm_heads(head + 1)    <= rearmed(head);
      left_out(head + 1)       <= missing(head);

    end generate every_decoder;

    acknowledged <= write_acknowledge or mean_acknowledged;

    sets : entity work.prepared_sets
      generic map (
        LANES => LANES,
        HEADS => HEADS
      )
      port map (
        clock            => clock,
        reset            => reset,
        access_read      => sets_read,
        access_write     => sets_write,
        access_set       => u_unsigned(access_address(14 downto 12)),
        access_word      => u_unsigned(access_address(11 downto 2)),
        access_data      => access_data,
        access_done      => sets_done,
        access_answer    => sets_data,
        write_lane       => coefficient_write,
        write_offset     => offset_write,
        write_mean       => mean_write,
        write_turn_step  => turns_write,
        write_address    => u_unsigned(access_address(9 downto 2)),
        write_data       => access_data,
        acknowledge_lane => lane_written,
        acknowledge_mean => mean_written,
        swap             => swap,
        load             => load_set,
        number           => set_number,
        busy             => set_busy,
        loaded           => set_loaded,
        lane_out         => bank.lane,
        offset_out       => bank.offset,
        mean_out         => bank.mean,
        turn_step_out    => bank.turn_step,
        address_out      => bank.address,
        data_out         => bank.data,
        acknowledged     => acknowledged,
        may_activate     => may_activate,
        refused          => swap_refused,
        swap_out         => bank.swap,
        swap_comes       => swap_comes
      );

    failing_heads : entity work.head_failover
      generic map (
        LANES => LANES,
        HEADS => HEADS
      )
      port map (
        clock              => clock,
        reset              => reset,
        read_enable        => heads_read,
        write_enable       => heads_write,
        address            => u_unsigned(access_address(7 downto 2)),
        write_data         => access_data,
        read_data          => failover_answer,
        take_snapshot      => take_snapshot,
        clear              => clear_output,
        steps              => steps,
        steps_up           => steps_up,
        illegals           => illegals,
        illegal_counts     => illegal_counts,
        overspeeds         => overspeeds,
        overspeed_counts   => overspeed_counts,
        swallowed          => swallowed,
        index_errors       => index_errors,
        index_error_counts => index_error_counts,
        indices_seen       => indices_seen,
        used               => used,
        idle_used          => idle_used,
        idle_carrier_used  => idle_carrier_used,
        differences        => differences,
        is_settled         => may_swap,
        swap_comes         => swap_comes,
        busy               => set_busy,
        loaded             => set_loaded,
        refused            => swap_refused,
        may_activate       => may_activate,
        load               => load_set,
        number             => set_number,
        rearm_heads        => rearmed,
        left_out           => missing,
        parity_beyond      => parity_beyond,
        changed            => failover_changed
      );

  else generate
    bank.lane        <= coefficient_write;
    bank.offset      <= offset_write;
    bank.turn_step   <= turns_write;
    bank.mean        <= mean_write;
    bank.address     <= u_unsigned(access_address(9 downto 2));
    bank.data        <= access_data;
    bank.swap        <= swap;
    lane_written     <= write_acknowledge;
    mean_written     <= mean_acknowledged;
    failover_answer  <= (others => '0');
    sets_done        <= '0';
    sets_data        <= (others => '0');
    rearm_heads      <= (others => '0');
    left_out         <= (others => '0');
    parity_beyond    <= '0';
    failover_changed <= '0';
  end generate leaves_out;

end architecture rtl;
