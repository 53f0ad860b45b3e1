-- SPDX-License-Identifier: Apache-2.0
--
-- # head_registers
--
-- Serves the register window of heads 3 and 4 and of the mean: pins, faults and snapshot of heads 3 and 4, delays of
-- all heads, commands and status. The register map defines these words. The window is not part of the generated
-- register block, so that a core without the mean does not contain it. access_guard passes only accesses to words that
-- exist.
--
-- **Latency.** 1 clock from `read_enable` or `write_enable` to `done`; `read_data` is valid with `done`.
--
-- **Number formats.** The register map states them. `pins` and `clear_heads` carry head 3 in the low bits; `delays` and
-- `indices_seen` carry head 1 there.
--
-- **Wide values.** A read of the position of a head's last index (word 4 of the head) latches the interval to the index
-- before it (word 5). `take_snapshot` latches the positions, the angle and the time of the last edge of each head, in
-- the clock in which the register block latches these values of heads 1 and 2.
--
-- **Reset** sets every setting to 0 and clears the sticky flag `heads_status.difference_limited`.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.decoder_pkg.all;
  use work.number_formats_pkg.all;

entity head_registers is
  port (
    clock              : in    std_ulogic;
    reset              : in    std_ulogic;
    read_enable        : in    std_ulogic;                     -- pulse: read the word
    write_enable       : in    std_ulogic;                     -- pulse: write the word
    address            : in    u_unsigned(5 downto 0);         -- number of the word in the window
    write_data         : in    std_ulogic_vector(31 downto 0); -- the word
    done               : out   std_ulogic := '0';              -- pulse: the word is read or written
    read_data          : out   std_ulogic_vector(31 downto 0); -- the word
    take_snapshot      : in    std_ulogic;                     -- pulse: latch the values of the heads
    -- Values of the heads
    head3              : in    decoded_head;
    head4              : in    decoded_head;
    indices_seen       : in    std_ulogic_vector(3 downto 0);  -- one bit per head: it has seen its index
    difference_limited : in    std_ulogic;                     -- high if the difference of a used head is limited
    clear_limited      : in    std_ulogic;                     -- pulse: clears the sticky flag of difference_limited
    -- Settings
    pins               : out   std_ulogic_vector(31 downto 0); -- 16 bits per head, in the layout of the registers
    clear_heads        : out   std_ulogic_vector(1 downto 0);  -- pulses, one bit per head: clear its faults
    delays             : out   std_ulogic_vector(31 downto 0) := (others => '0') -- clocks, 8 bits per head, head 1 in the low bits
  );
end entity head_registers;

architecture rtl of head_registers is

  constant DELAYS_WORD  : natural := 32;
  constant COMMAND_WORD : natural := 33;
  constant STATUS_WORD  : natural := 34;

  subtype word is std_ulogic_vector(31 downto 0);

  type words is array (0 to 15) of word;

  type words_of_heads is array (0 to 1) of words;

  type pins_of_heads is array (0 to 1) of std_ulogic_vector(15 downto 0);

  type snapshots_of_heads is array (0 to 1) of std_ulogic_vector(POSITION_WIDTH * 2 + ANGLE_WIDTH + TIMESTAMP_WIDTH - 1 downto 0);

  type counts_of_heads is array (0 to 1) of word;

  -- Returns the values of a head that a snapshot latches: time of its last edge, angle, turn position, position.
  function snapshot_of (head : decoded_head) return std_ulogic_vector is
  begin

    return std_ulogic_vector(head.last_edge_time) & std_ulogic_vector(head.angle)
           & std_ulogic_vector(head.turn_position) & std_ulogic_vector(head.position);

  end function snapshot_of;

  -- Returns the words of a head; the arguments hold the settings and the latched values.
  function words_of (
    head     : decoded_head;
    settings : std_ulogic_vector(15 downto 0);
    interval : word;
    snapshot : std_ulogic_vector
  ) return words is

    variable result : words := (others => (others => '0'));

  begin

    result(0)(15 downto 0) := settings;
    result(1)(6 downto 0)  := head.swallowed & head.index_direction & head.direction & head.overspeed & head.illegal
                              & head.index_error & head.index_seen;
    result(2)              := std_ulogic_vector(head.illegal_count) & std_ulogic_vector(head.index_error_count);
    result(3)(15 downto 0) := std_ulogic_vector(head.overspeed_count);
    result(4)              := std_ulogic_vector(head.index_position);
    result(5)              := interval;
    result(6)              := snapshot(31 downto 0);
    result(7)              := snapshot(63 downto 32);
    result(8)(ANGLE_WIDTH - 1 downto 0) := snapshot(63 + ANGLE_WIDTH downto 64);
    result(10)             := snapshot(95 + ANGLE_WIDTH downto 64 + ANGLE_WIDTH);
    result(11)             := snapshot(127 + ANGLE_WIDTH downto 96 + ANGLE_WIDTH);
    return result;

  end function words_of;

  signal settings  : pins_of_heads      := (others => (others => '0'));
  signal intervals : counts_of_heads    := (others => (others => '0'));
  signal snapshots : snapshots_of_heads := (others => (others => '0'));
  signal limited   : std_ulogic         := '0';

begin

  pins <= settings(1) & settings(0);

  answer : process (clock) is

    variable of_heads : words_of_heads;
    variable chosen   : word;

  begin

    if rising_edge(clock) then
      of_heads(0) := words_of(head3, settings(0), intervals(0), snapshots(0));
      of_heads(1) := words_of(head4, settings(1), intervals(1), snapshots(1));

      chosen := (others => '0');
      if address < 16 then
        chosen := of_heads(0)(to_integer(address(3 downto 0)));
      elsif address < 32 then
        chosen := of_heads(1)(to_integer(address(3 downto 0)));
      elsif address = DELAYS_WORD then
        chosen := delays;
      elsif address = STATUS_WORD then
        chosen(11 downto 8) := indices_seen;
        chosen(12)          := limited;
      end if;
      read_data <= chosen;
      done      <= read_enable or write_enable;

      limited     <= (limited and not clear_limited) or difference_limited;
      clear_heads <= "00";
      if write_enable = '1' then
        if address = 0 then
          settings(0) <= write_data(15 downto 8) & "0000" & write_data(3 downto 0);
        elsif address = 16 then
          settings(1) <= write_data(15 downto 8) & "0000" & write_data(3 downto 0);
        elsif address = DELAYS_WORD then
          delays <= write_data;
        elsif address = COMMAND_WORD then
          clear_heads <= write_data(1 downto 0);
        end if;
      end if;

      if read_enable = '1' and address = 4 then
        intervals(0) <= std_ulogic_vector(head3.index_interval);
      end if;
      if read_enable = '1' and address = 20 then
        intervals(1) <= std_ulogic_vector(head4.index_interval);
      end if;
      if take_snapshot = '1' then
        snapshots(0) <= snapshot_of(head3);
        snapshots(1) <= snapshot_of(head4);
      end if;

      if reset = '1' then
        settings    <= (others => (others => '0'));
        delays      <= (others => '0');
        clear_heads <= "00";
        limited     <= '0';
        done        <= '0';
      end if;
    end if;

  end process answer;

end architecture rtl;
