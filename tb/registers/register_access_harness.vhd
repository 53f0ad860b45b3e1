-- SPDX-License-Identifier: Apache-2.0
--
-- Connects register_access to the generated register block and to simple memories, for simulation. The offset and every
-- window except the capture window are memories; a word of the capture window contains its own word index in the low
-- half and the inverted index in the high half. All answer `memory_latency` + 1 clocks after the request.
-- scripts/register_words.py writes a wrapper with one port per register.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.arctrue_registers_pkg.all;
  use work.axi_lite_pkg.all;

entity register_access_harness is
  generic (
    LANES         : positive := 4;
    CAPTURE_DEPTH : positive := 100;
    HEADS         : positive := 2;
    MEAN          : boolean  := false;
    FAILOVER      : boolean  := false;
    LOCAL_TABLE   : boolean  := false;
    REAL_ORDERS   : boolean  := false
  );
  port (
    clock           : in    std_ulogic;
    reset           : in    std_ulogic;
    s_axil_request  : in    axi_lite_request;
    s_axil_response : out   axi_lite_response;
    interrupt       : out   std_ulogic;
    memory_latency  : in    u_unsigned(3 downto 0);
    hwif_in         : in    arctrue_registers_in_t;
    hwif_out        : out   arctrue_registers_out_t
  );
end entity register_access_harness;

architecture simulation of register_access_harness is

  type words is array (natural range <>) of std_ulogic_vector(31 downto 0);

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
  signal heads_read        : std_ulogic;
  signal heads_write       : std_ulogic;
  signal heads_done        : std_ulogic := '0';
  signal heads_data        : std_ulogic_vector(31 downto 0);
  signal sets_read         : std_ulogic;
  signal sets_write        : std_ulogic;
  signal sets_done         : std_ulogic := '0';
  signal sets_data         : std_ulogic_vector(31 downto 0);
  signal local_read        : std_ulogic;
  signal local_write       : std_ulogic;
  signal local_done        : std_ulogic := '0';
  signal local_data        : std_ulogic_vector(31 downto 0);
  signal turns_read        : std_ulogic;
  signal turns_write       : std_ulogic;
  signal turns_done        : std_ulogic := '0';
  signal turns_data        : std_ulogic_vector(31 downto 0);
  signal capture_read      : std_ulogic;
  signal capture_done      : std_ulogic := '0';
  signal capture_data      : std_ulogic_vector(31 downto 0);

begin

  processor : entity work.register_access
    generic map (
      LANES         => LANES,
      CAPTURE_DEPTH => CAPTURE_DEPTH,
      HEADS         => HEADS,
      MEAN          => MEAN,
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
      capture_ready     => hwif_in.status.capture_ready.next_q,
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
      local_read        => local_read,
      local_write       => local_write,
      local_done        => local_done,
      local_data        => local_data,
      turns_read        => turns_read,
      turns_write       => turns_write,
      turns_done        => turns_done,
      turns_data        => turns_data,
      take_snapshot     => open,
      capture_read      => capture_read,
      capture_done      => capture_done,
      capture_data      => capture_data
    );

  interrupt <= hwif_out.interrupt_status.intr;

  memories : process (clock) is

    variable coefficients : words(0 to 255)               := (others => (others => '0'));
    variable offset       : std_ulogic_vector(31 downto 0) := (others => '0');
    variable waiting      : natural range 0 to 15          := 0;
    variable word         : natural range 0 to 32767       := 0;
    variable mean_words   : words(0 to 15)                 := (others => (others => '0'));
    variable head_words   : words(0 to 63)                 := (others => (others => '0'));
    variable set_words    : words(0 to 8191)               := (others => (others => '0'));
    -- Memory of the local table: the points, then the words of `local_place`
    variable local_words  : words(0 to 8191)               := (others => (others => '0'));
    variable local_word   : natural range 0 to 8191        := 0;
    variable turn_words   : words(0 to 255)                := (others => (others => '0'));
    variable window       : std_ulogic_vector(7 downto 0)  := "00000000";
    variable answer       : std_ulogic_vector(7 downto 0);

  begin

    if rising_edge(clock) then
      answer := "00000000";
      if waiting = 1 then
        answer := window;
      end if;
      if waiting /= 0 then
        waiting := waiting - 1;
      end if;

      if (coefficient_read or coefficient_write or offset_read or offset_write
          or mean_read or mean_write or heads_read or heads_write or sets_read or sets_write
          or local_read or local_write or turns_read or turns_write or capture_read) = '1' then
        assert waiting = 0
          report "a request before the answer to the last one"
          severity failure;
        waiting  := to_integer(memory_latency);
        window   := (turns_read or turns_write) & (local_read or local_write) & (sets_read or sets_write)
                    & (heads_read or heads_write) & (mean_read or mean_write) & capture_read
                    & (offset_read or offset_write) & (coefficient_read or coefficient_write);
        word     := to_integer(u_unsigned(access_address(16 downto 2)));
        if window(0) = '1' then
          word := to_integer(u_unsigned(access_address(9 downto 2)));
        end if;
        local_word := to_integer(not access_address(16) & u_unsigned(access_address(13 downto 2)));
        if coefficient_write = '1' then
          coefficients(word) := access_data;
        elsif offset_write = '1' then
          offset := access_data;
        elsif mean_write = '1' then
          mean_words(word mod 16) := access_data;
        elsif heads_write = '1' then
          head_words(word mod 64) := access_data;
        elsif sets_write = '1' then
          set_words(word mod 8192) := access_data;
        elsif local_write = '1' then
          local_words(local_word) := access_data;
        elsif turns_write = '1' then
          turn_words(word mod 256) := access_data;
        end if;
      end if;

      coefficient_done <= answer(0) or answer(1);
      coefficient_data <= coefficients(word mod 256);
      offset_data      <= offset;
      mean_done        <= answer(3);
      mean_data        <= mean_words(word mod 16);
      heads_done       <= answer(4);
      heads_data       <= head_words(word mod 64);
      sets_done        <= answer(5);
      sets_data        <= set_words(word mod 8192);
      local_done       <= answer(6);
      local_data       <= local_words(local_word);
      turns_done       <= answer(7);
      turns_data       <= turn_words(word mod 256);
      capture_done     <= answer(2);
      capture_data     <= not std_ulogic_vector(to_unsigned(word, 16)) & std_ulogic_vector(to_unsigned(word, 16));
    end if;

  end process memories;

end architecture simulation;
