-- SPDX-License-Identifier: Apache-2.0
--
-- # access_guard
--
-- Decides which unit serves an access to the register map. This is the generated register block, the capture, or one of
-- the units with the other words: coefficients of the lanes, coefficient offset, mean, heads 3 and 4, prepared sets,
-- conditions, local table, turn steps and turn number. It refuses an access if no unit serves the address, if the
-- address belongs to a lane, a head, a mean, a prepared set, conditions, a local table or turn steps that the core does
-- not contain, or if the register map does not allow a read or a write of the register. It also refuses a write that
-- does not carry all four bytes, except to the register block. It refuses every write to the capture, every read of the
-- capture while no bank is ready, and every read beyond CAPTURE_DEPTH samples.
--
-- **Latency.** 1 clock from `judge` to the verdict, that is the outputs from `to_registers` to `refused`. Exactly one
-- of them is high, until the next verdict. In the first clock of the verdict the unit gets a pulse that requests the
-- read or the write.
--
-- **Number formats.** Addresses are in bytes.
--
-- **Reset.** There is none: the outputs show the verdict on the access of the last `judge`; they are undefined before
-- the first one.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.axi_lite_pkg.all;
  use work.number_formats_pkg.all;
  use work.register_addresses_pkg.all;
  use work.tolerance_pkg.all;

entity access_guard is
  generic (
    LANES         : positive range 1 to LANES_MAX := LANES_DEFAULT;
    CAPTURE_DEPTH : positive range 2 to 16384     := CAPTURE_DEPTH_DEFAULT;
    HEADS         : positive range 2 to HEADS_MAX := 2;
    MEAN          : boolean                       := false;
    MODULATORS    : boolean                       := false;
    FAILOVER      : boolean                       := false;
    LOCAL_TABLE   : boolean                       := false;
    REAL_ORDERS   : boolean                       := false
  );
  port (
    clock           : in    std_ulogic;
    judge           : in    std_ulogic;                     -- pulse: judge the access at the inputs
    capture_ready   : in    std_ulogic;                     -- level: a capture bank belongs to the processor
    address         : in    axi_lite_address;               -- bytes
    is_write        : in    std_ulogic;
    write_strobes   : in    std_ulogic_vector(3 downto 0);  -- one bit per byte
    to_registers    : out   std_ulogic;
    to_coefficients : out   std_ulogic;
    to_offset       : out   std_ulogic;
    to_mean         : out   std_ulogic;
    to_heads        : out   std_ulogic;
    to_conditions   : out   std_ulogic;
    to_sets         : out   std_ulogic;
    to_local        : out   std_ulogic;
    to_turns        : out   std_ulogic;
    to_capture      : out   std_ulogic;
    refused         : out   std_ulogic;
    -- Pulses in the first clock of the verdict
    ask_registers     : out   std_ulogic := '0';
    read_coefficient  : out   std_ulogic := '0';
    write_coefficient : out   std_ulogic := '0';
    read_offset       : out   std_ulogic := '0';
    write_offset      : out   std_ulogic := '0';
    read_mean         : out   std_ulogic := '0';
    write_mean        : out   std_ulogic := '0';
    read_heads        : out   std_ulogic := '0';
    write_heads       : out   std_ulogic := '0';
    read_set          : out   std_ulogic := '0';
    write_set         : out   std_ulogic := '0';
    read_conditions   : out   std_ulogic := '0';
    write_conditions  : out   std_ulogic := '0';
    read_local        : out   std_ulogic := '0';
    write_local       : out   std_ulogic := '0';
    read_turns        : out   std_ulogic := '0';
    write_turns       : out   std_ulogic := '0';
    read_capture      : out   std_ulogic := '0'
  );
end entity access_guard;

architecture rtl of access_guard is

  subtype byte_address is u_unsigned(axi_lite_address'range);

  constant COEFFICIENTS_FIRST : byte_address := to_unsigned(COEFFICIENTS_ADDRESS, AXI_LITE_ADDRESS_WIDTH);
  constant CAPTURE_FIRST      : byte_address := to_unsigned(CAPTURE_ADDRESS, AXI_LITE_ADDRESS_WIDTH);
  constant OFFSET_WORD        : byte_address := to_unsigned(COEFFICIENT_OFFSET_ADDRESS, AXI_LITE_ADDRESS_WIDTH);
  constant MEAN_FIRST         : byte_address := to_unsigned(MEAN_ADDRESS, AXI_LITE_ADDRESS_WIDTH);
  constant HEADS_FIRST        : byte_address := to_unsigned(HEAD3_ADDRESS, AXI_LITE_ADDRESS_WIDTH);
  constant CONDITIONS_FIRST   : byte_address := to_unsigned(CONDITIONS_ADDRESS, AXI_LITE_ADDRESS_WIDTH);
  constant SETS_FIRST         : byte_address := to_unsigned(PREPARED_SETS_ADDRESS, AXI_LITE_ADDRESS_WIDTH);
  constant PLACE_FIRST        : byte_address := to_unsigned(LOCAL_PLACE_ADDRESS, AXI_LITE_ADDRESS_WIDTH);
  constant TURNS_FIRST        : byte_address := to_unsigned(TURN_STEPS_ADDRESS, AXI_LITE_ADDRESS_WIDTH);
  constant POINTS_FIRST       : byte_address := to_unsigned(LOCAL_POINTS_ADDRESS, AXI_LITE_ADDRESS_WIDTH);
  constant FURTHER_FIRST      : byte_address := to_unsigned(FURTHER_CAPTURE_ADDRESS, AXI_LITE_ADDRESS_WIDTH);

  -- Returns bit number `place` of a table. Each bit of `place`, from the highest on, selects one half of the remaining
  -- bits of the table. (If the code indexed the table, tools would build a memory, and a proof by induction treats the
  -- contents of a memory as unknown.)
  function bit_of (
    table : std_ulogic_vector;
    place : u_unsigned
  ) return std_ulogic is

    variable left_over : std_ulogic_vector(0 to 2 ** place'length - 1);
    variable number    : u_unsigned(place'length - 1 downto 0);

  begin

    left_over := table;
    number    := place;

    for digit in number'range loop
      if number(digit) = '1' then
        left_over(0 to 2 ** digit - 1) := left_over(2 ** digit to 2 * 2 ** digit - 1);
      end if;
    end loop;

    return left_over(0);

  end function bit_of;

begin

  assert CAPTURE_ADDRESS = 16#20000# and FURTHER_CAPTURE_ADDRESS = 16#40000# and COEFFICIENTS_ADDRESS mod 1024 = 0
         and MEAN_ADDRESS mod 64 = 0 and HEAD3_ADDRESS mod 256 = 0 and CONDITIONS_ADDRESS mod 64 = 0
         and PREPARED_SETS_ADDRESS = 16#8000# and LOCAL_PLACE_ADDRESS mod 32 = 0 and LOCAL_POINTS_ADDRESS = 16#10000#
         and TURN_STEPS_ADDRESS mod 2048 = 1024
    report "access_guard: the windows of the register map have moved; adapt the decoding"
    severity failure;

  verdict : process (clock) is

    variable place        : byte_address;
    variable lane         : u_unsigned(5 downto 0);
    variable sample       : u_unsigned(13 downto 0);
    variable partial      : boolean;
    variable word         : u_unsigned(REGISTERS_ADDRESS_WIDTH - 1 downto 2);
    variable legal        : std_ulogic;
    variable registers    : boolean;
    variable coefficients : boolean;
    variable is_offset    : boolean;
    variable offset       : boolean;
    variable capture      : boolean;
    variable mean_word    : boolean;
    variable of_mean      : boolean;
    variable head_word    : natural range 0 to 63;
    variable of_head      : boolean;
    variable of_failover  : boolean;
    variable of_heads     : boolean;
    variable conditions   : boolean;
    variable of_set       : boolean;
    variable of_local     : boolean;
    variable of_turns     : boolean;

  begin

    if rising_edge(clock) then
      place   := u_unsigned(address);
      lane    := place(9 downto 4);
      sample  := place(16 downto 3);
      partial := is_write = '1' and write_strobes /= "1111";

      -- Windows are aligned to their size: 1 KiB of coefficients, 64 bytes of the mean, 128 KiB of capture.
      is_offset    := place(place'high downto 2) = OFFSET_WORD(place'high downto 2);
      word         := place(REGISTERS_ADDRESS_WIDTH - 1 downto 2);
      legal        := bit_of(MAY_BE_READ, word);
      if is_write = '1' then
        legal := bit_of(MAY_BE_WRITTEN, word);
      end if;
      registers    := place(place'high downto REGISTERS_ADDRESS_WIDTH) = 0 and legal = '1';
      offset       := is_offset and not partial;
      coefficients := place(place'high downto 10) = COEFFICIENTS_FIRST(place'high downto 10)
                      and not partial and is_at_most(lane, LANES - 1);
      -- The words of the mean: offsets, weights, and the choice of heads.
      mean_word    := (place(5) = '0' and is_at_most(place(3 downto 2), HEADS - 1)) or place(5 downto 2) = 2 * HEADS_MAX;
      of_mean      := MEAN and mean_word and not partial
                      and place(place'high downto 6) = MEAN_FIRST(place'high downto 6);
      -- Each of heads 3 and 4 has words 0 to 8, 10 and 11, of which only word 0 may be written. Words 32 to 34 are
      -- delays, command and status.
      head_word    := to_integer(place(7 downto 2));
      of_head      := (head_word < 16 and HEADS > 2) or (head_word >= 16 and head_word < 32 and HEADS > 3);
      of_head      := of_head and (head_word mod 16 < 9 or head_word mod 16 = 10 or head_word mod 16 = 11);
      -- The words of the failover: settings, weights of the parity, value of the parity, and two limits.
      of_failover  := head_word = 35 or head_word = 36 or (head_word >= 40 and head_word < 40 + HEADS)
                      or (head_word >= 44 and head_word < 47);
      if is_write = '1' then
        of_head := (of_head and head_word mod 16 = 0) or head_word = 32 or (head_word = 33 and HEADS > 2);
        of_head := of_head or (FAILOVER and of_failover and head_word /= 44);
      else
        of_head := of_head or head_word = 32 or head_word = 34 or (FAILOVER and of_failover);
      end if;
      of_heads     := MEAN and of_head and not partial and place(place'high downto 8) = HEADS_FIRST(place'high downto 8);
      -- The conditions have words 0 to 8, of which words 0 to 5 may be written.
      conditions   := MODULATORS and not partial
                      and place(place'high downto 6) = CONDITIONS_FIRST(place'high downto 6)
                      and (is_at_most(place(5 downto 2), 5) or (is_write = '0' and is_at_most(place(5 downto 2), 8)));
      -- A set has the layout of the windows from 0x1000 on: coefficients, mean, and the coefficient offset as its last
      -- word.
      of_set       := FAILOVER and not partial and place(place'high downto 15) = SETS_FIRST(place'high downto 15)
                      and is_at_most(place(14 downto 12), HEADS)
                      and ((place(11 downto 10) = "00" and is_at_most(lane, LANES - 1))
                           or (place(11 downto 6) = "100000" and (mean_word or place(5 downto 2) = "1111")));
      -- The local table has seven words for the place of its windows, and 4,096 points.
      of_local     := LOCAL_TABLE and not partial
                      and ((place(place'high downto 5) = PLACE_FIRST(place'high downto 5) and is_at_most(place(4 downto 2), 6))
                           or place(place'high downto 14) = POINTS_FIRST(place'high downto 14));
      -- Each lane has two words of its turn step. The turn number follows after the words of 64 lanes; it can only be
      -- read.
      of_turns     := REAL_ORDERS and not partial and place(place'high downto 10) = TURNS_FIRST(place'high downto 10)
                      and ((place(9) = '0' and is_at_most(place(8 downto 3), LANES - 1))
                           or (is_write = '0' and place(9 downto 2) = 128));
      capture      := (place(place'high downto 17) = CAPTURE_FIRST(place'high downto 17)
                       or (HEADS > 2 and place(place'high downto 17) = FURTHER_FIRST(place'high downto 17)
                           and (HEADS > 3 or place(2) = '0')))
                      and is_write = '0' and capture_ready = '1' and is_at_most(sample, CAPTURE_DEPTH - 1);

      ask_registers     <= '0';
      read_coefficient  <= '0';
      write_coefficient <= '0';
      read_offset       <= '0';
      write_offset      <= '0';
      read_mean         <= '0';
      write_mean        <= '0';
      read_heads        <= '0';
      write_heads       <= '0';
      read_set          <= '0';
      write_set         <= '0';
      read_conditions   <= '0';
      write_conditions  <= '0';
      read_local        <= '0';
      write_local       <= '0';
      read_turns        <= '0';
      write_turns       <= '0';
      read_capture      <= '0';
      if judge = '1' then
        ask_registers     <= '1' when registers else '0';
        read_coefficient  <= not is_write when coefficients else '0';
        write_coefficient <= is_write when coefficients else '0';
        read_offset       <= not is_write when offset else '0';
        write_offset      <= is_write when offset else '0';
        read_mean         <= not is_write when of_mean else '0';
        write_mean        <= is_write when of_mean else '0';
        read_heads        <= not is_write when of_heads else '0';
        write_heads       <= is_write when of_heads else '0';
        read_set          <= not is_write when of_set else '0';
        write_set         <= is_write when of_set else '0';
        read_conditions   <= not is_write when conditions else '0';
        write_conditions  <= is_write when conditions else '0';
        read_local        <= not is_write when of_local else '0';
        write_local       <= is_write when of_local else '0';
        read_turns        <= not is_write when of_turns else '0';
        write_turns       <= is_write when of_turns else '0';
        read_capture      <= '1' when capture else '0';
        to_registers    <= '1' when registers else '0';
        to_coefficients <= '1' when coefficients else '0';
        to_offset       <= '1' when offset else '0';
        to_mean         <= '1' when of_mean else '0';
        to_heads        <= '1' when of_heads else '0';
        to_sets         <= '1' when of_set else '0';
        to_conditions   <= '1' when conditions else '0';
        to_local        <= '1' when of_local else '0';
        to_turns        <= '1' when of_turns else '0';
        to_capture      <= '1' when capture else '0';
        refused         <= '0' when registers or coefficients or offset or of_mean or of_heads or of_set or conditions
                           or of_local or of_turns or capture else '1';
      end if;
    end if;

  end process verdict;

end architecture rtl;
