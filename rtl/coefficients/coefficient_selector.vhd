-- SPDX-License-Identifier: Apache-2.0
--
-- # coefficient_selector
--
-- Gives a folded pipeline the words of its lanes in turn: in slot s the words of the s-th block of
-- LANES / FOLD neighbouring lanes. All of them come from the active bank of coefficient_memory, so
-- the bank stays the one place that a swap changes. With FOLD = 1 it is wires.
--
-- **Latency.** None from `words` to `selected`. The block of slot s is selected CLOCKS + s clocks after
-- the angle was accepted, which is where the pipeline needs this kind of word.
--
-- **Number formats.** WIDTH bits a lane of any meaning, lane 0 in the low bits; slot 0 to FOLD - 1.
--
-- There is no reset: which block is selected follows from `slot` one clock later.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.number_formats_pkg.all;

entity coefficient_selector is
  generic (
    LANES  : positive range 1 to LANES_MAX := LANES_DEFAULT;
    FOLD   : positive range 1 to 8         := 1;  -- lanes that share a pipeline: 1, 2, 4 or 8
    WIDTH  : positive                      := PHASE_STEP_WIDTH;
    CLOCKS : natural                       := 0   -- from an angle to the first word that it meets
  );
  port (
    clock    : in    std_ulogic;
    slot     : in    u_unsigned(2 downto 0);                             -- 0 with an accepted angle
    words    : in    std_ulogic_vector(LANES * WIDTH - 1 downto 0);      -- of all lanes
    selected : out   std_ulogic_vector(LANES / FOLD * WIDTH - 1 downto 0) -- of one block of lanes
  );
end entity coefficient_selector;

architecture rtl of coefficient_selector is

  constant BLOCK_WIDTH : positive := LANES / FOLD * WIDTH;

begin

  unfolded : if FOLD = 1 generate

    selected <= words;

  end generate unfolded;

  folded : if FOLD > 1 generate

    -- The clock before it, the slot is one less.
    constant AHEAD : natural := (1 - CLOCKS) mod FOLD;

    signal chosen : u_unsigned(2 downto 0) := to_unsigned((-CLOCKS) mod FOLD, 3);

  begin

    choose : process (clock) is
    begin

      if rising_edge(clock) then
        chosen <= (slot + AHEAD) and to_unsigned(FOLD - 1, 3);
      end if;

    end process choose;

    multiplex : process (all) is

      variable left_over : std_ulogic_vector(words'range);
      variable half      : natural;

    begin

      left_over := words;
      half      := words'length / 2;

      -- The highest bit of the number chooses a half of the blocks, and so on.
      for place in 2 downto 0 loop
        if 2 ** place < FOLD then
          if chosen(place) = '1' then
            left_over(half - 1 downto 0) := left_over(2 * half - 1 downto half);
          end if;
          half := half / 2;
        end if;
      end loop;

      selected <= left_over(BLOCK_WIDTH - 1 downto 0);

    end process multiplex;

  end generate folded;

end architecture rtl;
