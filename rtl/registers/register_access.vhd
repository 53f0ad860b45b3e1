-- SPDX-License-Identifier: Apache-2.0
--
-- # register_access
--
-- Connects the processor to the core. It contains the AXI4-Lite port (axi_lite_access), access_guard, which decides
-- which unit serves a transfer, the register block generated from the map, and the connection to the words of other
-- units. The entity processes one transfer at a time; each step of a transfer takes one clock.
--
-- **Latency.** For a register, 4 clocks from `arvalid` to the response of a read, and 3 clocks from `awvalid` and
-- `wvalid` to the response of a write. The address is decoded in the clock of the check; a read takes a clock more,
-- because the block stores the word in a register. Another unit gets its request 2 clocks after `arvalid`, or `awvalid`
-- and `wvalid`; the response follows one clock after the unit's answer.
--
-- **Number formats.** Addresses are in bytes; the register map states all other formats.
--
-- **Other units.** Each read or write of a word of another unit is requested by a pulse. `access_address` and
-- `access_data` are valid from the clock before this pulse until the answer. The unit answers by one pulse, in the same
-- clock or later; for a read it outputs the word with this pulse.
--
-- **Reset** drops the present transfer, so master and units must be reset with it.

library ieee;
  use ieee.std_logic_1164.all;

  use work.arctrue_registers_pkg.all;
  use work.axi_lite_pkg.all;
  use work.number_formats_pkg.all;
  use work.register_addresses_pkg.all;

entity register_access is
  generic (
    LANES         : positive range 1 to LANES_MAX := LANES_DEFAULT;        -- number of harmonic lanes
    CAPTURE_DEPTH : positive range 2 to 16384     := CAPTURE_DEPTH_DEFAULT; -- number of samples in a capture bank
    HEADS         : positive range 2 to HEADS_MAX := 2;
    MEAN          : boolean                       := false; -- the mean of the heads is built
    MODULATORS    : boolean                       := false; -- amplitudes can follow motion or a processor word
    FAILOVER      : boolean                       := false; -- a failed head can be left out of the mean
    LOCAL_TABLE   : boolean                       := false; -- a local table is built
    REAL_ORDERS   : boolean                       := false  -- the order of a lane need not be an integer
  );
  port (
    clock             : in    std_ulogic;
    reset             : in    std_ulogic;
    -- AXI4-Lite slave, 512 KiB, see axi_lite_pkg
    s_axil_request    : in    axi_lite_request;
    s_axil_response   : out   axi_lite_response;
    -- Fields of the register block
    hwif_in           : in    arctrue_registers_in_t;
    hwif_out          : out   arctrue_registers_out_t;
    -- Requests to other units, and their answers
    capture_ready     : in    std_ulogic;                     -- level: a capture bank belongs to the processor
    access_address    : out   axi_lite_address;               -- bytes
    access_data       : out   std_ulogic_vector(31 downto 0); -- word to be written
    coefficient_read  : out   std_ulogic;                     -- pulse: read the word
    coefficient_write : out   std_ulogic;                     -- pulse: write the word
    coefficient_data  : in    std_ulogic_vector(31 downto 0);
    offset_read       : out   std_ulogic;                     -- pulse: read the word
    offset_write      : out   std_ulogic;                     -- pulse: write the word
    offset_data       : in    std_ulogic_vector(31 downto 0);
    coefficient_done  : in    std_ulogic;                     -- pulse: the coefficient or the offset is read or written
    mean_read         : out   std_ulogic;                     -- pulse: read the word
    mean_write        : out   std_ulogic;                     -- pulse: write the word
    mean_done         : in    std_ulogic := '0';              -- pulse: the word is read or written
    mean_data         : in    std_ulogic_vector(31 downto 0) := (others => '0');
    heads_read        : out   std_ulogic;                     -- pulse: read the word
    heads_write       : out   std_ulogic;                     -- pulse: write the word
    heads_done        : in    std_ulogic := '0';              -- pulse: the word is read or written
    heads_data        : in    std_ulogic_vector(31 downto 0) := (others => '0');
    sets_read         : out   std_ulogic;                     -- pulse: read the word
    sets_write        : out   std_ulogic;                     -- pulse: write the word
    sets_done         : in    std_ulogic := '0';              -- pulse: the word is read or written
    sets_data         : in    std_ulogic_vector(31 downto 0) := (others => '0');
    conditions_read   : out   std_ulogic;                     -- pulse: read the word
    conditions_write  : out   std_ulogic;                     -- pulse: write the word
    conditions_done   : in    std_ulogic := '0';              -- pulse: the word is read or written
    conditions_data   : in    std_ulogic_vector(31 downto 0) := (others => '0');
    local_read        : out   std_ulogic;                     -- pulse: read the word
    local_write       : out   std_ulogic;                     -- pulse: write the word
    local_done        : in    std_ulogic := '0';              -- pulse: the word is read or written
    local_data        : in    std_ulogic_vector(31 downto 0) := (others => '0');
    turns_read        : out   std_ulogic;                     -- pulse: read the word
    turns_write       : out   std_ulogic;                     -- pulse: write the word
    turns_done        : in    std_ulogic := '0';              -- pulse: the word is read or written
    turns_data        : in    std_ulogic_vector(31 downto 0) := (others => '0');
    take_snapshot     : out   std_ulogic;                     -- pulse: latch the registers of the snapshot
    capture_read      : out   std_ulogic;                     -- pulse: read the word
    capture_done      : in    std_ulogic;                     -- pulse: the word is read
    capture_data      : in    std_ulogic_vector(31 downto 0)
  );
end entity register_access;

architecture rtl of register_access is

  signal taken           : std_ulogic;
  signal is_write        : std_ulogic;
  signal write_strobes   : std_ulogic_vector(3 downto 0);
  signal write_enables   : std_ulogic_vector(31 downto 0);
  signal refused         : std_ulogic;
  signal answered        : std_ulogic;
  signal data            : std_ulogic_vector(31 downto 0);
  signal to_registers    : std_ulogic;
  signal to_coefficients : std_ulogic;
  signal to_offset       : std_ulogic;
  signal to_mean         : std_ulogic;
  signal to_heads        : std_ulogic;
  signal to_conditions   : std_ulogic;
  signal to_sets         : std_ulogic;
  signal to_local        : std_ulogic;
  signal to_turns        : std_ulogic;
  signal to_capture      : std_ulogic;

  signal judge            : std_ulogic;
  signal register_request : std_ulogic;
  signal register_read    : std_ulogic;
  signal register_data    : std_ulogic_vector(31 downto 0);
  signal register_writes  : std_ulogic;
  signal word_asked       : std_ulogic_vector(0 to 2 ** (REGISTERS_ADDRESS_WIDTH - 2) - 1);
  signal register_written : std_ulogic;

  -- Returns a vector with one bit for each possible `place`; only the bit at `place` is high.
  function decoded (place : std_ulogic_vector) return std_ulogic_vector is

    alias    digits : std_ulogic_vector(place'length - 1 downto 0) is place;
    variable result : std_ulogic_vector(0 to 2 ** place'length - 1);

  begin

    result := (0 => '1', others => '0');

    for digit in 0 to digits'high loop
      result(2 ** digit to 2 * 2 ** digit - 1) := result(0 to 2 ** digit - 1) and digits(digit);
      result(0 to 2 ** digit - 1)              := result(0 to 2 ** digit - 1) and not digits(digit);
    end loop;

    return result;

  end function decoded;

begin

  bus_port : entity work.axi_lite_access
    port map (
      clock           => clock,
      reset           => reset,
      s_axil_request  => s_axil_request,
      s_axil_response => s_axil_response,
      taken           => taken,
      address         => access_address,
      is_write        => is_write,
      write_data      => access_data,
      write_strobes   => write_strobes,
      refused         => refused,
      answered        => answered,
      data            => data
    );

  judge <= taken and not reset;

  guard : entity work.access_guard
    generic map (
      LANES         => LANES,
      CAPTURE_DEPTH => CAPTURE_DEPTH,
      HEADS         => HEADS,
      MEAN          => MEAN,
      MODULATORS    => MODULATORS,
      FAILOVER      => FAILOVER,
      LOCAL_TABLE   => LOCAL_TABLE,
      REAL_ORDERS   => REAL_ORDERS
    )
    port map (
      clock           => clock,
      judge           => judge,
      capture_ready   => capture_ready,
      address         => access_address,
      is_write        => is_write,
      write_strobes   => write_strobes,
      to_registers    => to_registers,
      to_coefficients => to_coefficients,
      to_offset       => to_offset,
      to_mean         => to_mean,
      to_heads        => to_heads,
      to_conditions   => to_conditions,
      to_sets         => to_sets,
      to_local        => to_local,
      to_turns        => to_turns,
      to_capture      => to_capture,
      refused         => refused,
      ask_registers   => register_request,
      read_coefficient  => coefficient_read,
      write_coefficient => coefficient_write,
      read_offset       => offset_read,
      write_offset      => offset_write,
      read_mean         => mean_read,
      write_mean        => mean_write,
      read_heads        => heads_read,
      write_heads       => heads_write,
      read_set          => sets_read,
      write_set         => sets_write,
      read_conditions   => conditions_read,
      write_conditions  => conditions_write,
      read_local        => local_read,
      write_local       => local_write,
      read_turns        => turns_read,
      write_turns       => turns_write,
      read_capture      => capture_read
    );

  byte_enables : for byte in write_strobes'range generate

    write_enables(8 * byte + 7 downto 8 * byte) <= (others => write_strobes(byte));

  end generate byte_enables;

  -- The block is generated without external registers, so it never stalls; it answers a write in the clock of the
  -- request and a read in the next clock.
  registers : entity work.arctrue_registers
    port map (
      clk                  => clock,
      rst                  => reset,
      s_cpuif_word         => word_asked,
      s_cpuif_req          => register_request,
      s_cpuif_req_is_wr    => register_writes,
      s_cpuif_addr         => access_address(REGISTERS_ADDRESS_WIDTH - 1 downto 0),
      s_cpuif_wr_data      => access_data,
      s_cpuif_wr_biten     => write_enables,
      s_cpuif_req_stall_wr => open,
      s_cpuif_req_stall_rd => open,
      s_cpuif_rd_ack       => register_read,
      s_cpuif_rd_err       => open,
      s_cpuif_rd_data      => register_data,
      s_cpuif_wr_ack       => register_written,
      s_cpuif_wr_err       => open,
      hwif_in              => hwif_in,
      hwif_out             => hwif_out
    );

  take_snapshot <= register_request and not register_writes and word_asked(SNAPSHOT_ADDRESS / 4);

  -- The block has its own copies of the decoded word address and of the kind of the access, because they drive about
  -- 500 bits there.
  hold_for_registers : process (clock) is
  begin

    if rising_edge(clock) then
      register_writes  <= is_write;
      word_asked       <= decoded(access_address(REGISTERS_ADDRESS_WIDTH - 1 downto 2));
    end if;

  end process hold_for_registers;

  answered <= register_read or register_written or coefficient_done or mean_done or heads_done or conditions_done or sets_done
              or local_done or turns_done or capture_done;
  data     <= (register_data and to_registers)
              or (coefficient_data and to_coefficients)
              or (offset_data and to_offset)
              or (mean_data and to_mean)
              or (heads_data and to_heads)
              or (conditions_data and to_conditions)
              or (sets_data and to_sets)
              or (local_data and to_local)
              or (turns_data and to_turns)
              or (capture_data and to_capture);

end architecture rtl;
