-- SPDX-License-Identifier: Apache-2.0
--
-- # quadrant_fold
--
-- Folds a phase into the first quadrant, where the rotation of equations (10) to (12) converges,
-- and signals whether the cosine of the phase is the negative of the cosine of the folded phase.
--
-- **Latency.** 1 clock.
--
-- **Number formats.** phase u0.24 turn; folded and place have 22 bits in units of 2⁻²⁴ turn, from 0 to one unit below a
-- quarter turn.
--
-- **Mirroring.** The place within the second or fourth quadrant is mirrored: `folded` is the complement of its bits.
-- The complement needs no adder; it is one unit (2⁻²⁴ turn) less than the exact mirrored angle, a quarter turn − place,
-- which changes the cosine by less than 4·10⁻⁷. A rotation that mirrors the angle itself uses `place` and `mirrored`
-- instead of `folded`.
--
-- There is no reset, because no register holds state.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.number_formats_pkg.all;

entity quadrant_fold is
  port (
    clock    : in    std_ulogic;
    phase    : in    u_unsigned(PHASE_WIDTH - 1 downto 0);                    -- turn, u0.24
    folded   : out   u_unsigned(PHASE_WIDTH - 3 downto 0) := (others => '0'); -- 2⁻²⁴ turn
    place    : out   u_unsigned(PHASE_WIDTH - 3 downto 0) := (others => '0'); -- 2⁻²⁴ turn, from the start of the quadrant
    mirrored : out   std_ulogic                           := '0';             -- level: folded is the complement of place
    negative : out   std_ulogic                           := '0'              -- level: cos(phase) = −cos(folded)
  );
end entity quadrant_fold;

architecture rtl of quadrant_fold is

begin

  fold : process (clock) is
  begin

    if rising_edge(clock) then
      place    <= phase(PHASE_WIDTH - 3 downto 0);
      mirrored <= phase(PHASE_WIDTH - 2);
      folded   <= phase(PHASE_WIDTH - 3 downto 0) xor (folded'range => phase(PHASE_WIDTH - 2));
      negative <= phase(PHASE_WIDTH - 1) xor phase(PHASE_WIDTH - 2);
    end if;

  end process fold;

end architecture rtl;
