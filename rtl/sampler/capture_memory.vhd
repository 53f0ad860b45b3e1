-- SPDX-License-Identifier: Apache-2.0
--
-- # capture_memory
--
-- Stores both capture banks in one block RAM: 2 * DEPTH words of 64 bits, with one write port and one read port. Sample
-- i of bank b lies at the address b * DEPTH + i, without a gap between the banks, so that 2 * 12,288 words fill 48
-- RAMB36 of the XC7Z020; banks padded to a power of two would need 64.
--
-- **Latency.** A word is written at the clock edge at the end of the clock in which `write_enable` is high. `read_data`
-- follows `read_address` by 2 clocks: one for the RAM's own register, one for its output register.
--
-- **Number formats.** A word holds the position of head 2 in bits 63..32 and of head 1 in bits 31..0, each s31.0
-- counts; in the second memory that sampler builds for more than two heads, those of heads 4 and 3.
--
-- There is no reset and no initial content: a word is undefined until it is written. A read of the address that is
-- being written gives the old word. Addresses from 2 * DEPTH on are not allowed.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.number_formats_pkg.all;

entity capture_memory is
  generic (
    DEPTH : positive range 2 to 16384 := CAPTURE_DEPTH_DEFAULT -- samples per bank
  );
  port (
    clock         : in    std_ulogic;
    write_enable  : in    std_ulogic;
    write_address : in    u_unsigned(14 downto 0);                            -- bank * DEPTH + sample
    write_data    : in    std_ulogic_vector(2 * POSITION_WIDTH - 1 downto 0); -- head 2, head 1
    read_address  : in    u_unsigned(14 downto 0);                            -- bank * DEPTH + sample
    read_data     : out   std_ulogic_vector(2 * POSITION_WIDTH - 1 downto 0)  -- head 2, head 1
  );
end entity capture_memory;

architecture rtl of capture_memory is

  type memory_words is array (0 to 2 * DEPTH - 1) of std_ulogic_vector(2 * POSITION_WIDTH - 1 downto 0);

begin

  access_memory : process (clock) is

    -- The memory is a variable, because a simulator would treat it as 1.5 million signals if it were a signal.
    variable memory : memory_words;
    variable word   : std_ulogic_vector(2 * POSITION_WIDTH - 1 downto 0);

  begin

    if rising_edge(clock) then
      read_data <= word;
      word      := memory(to_integer(read_address));
      if write_enable = '1' then
        memory(to_integer(write_address)) := write_data;
      end if;
    end if;

  end process access_memory;

end architecture rtl;
