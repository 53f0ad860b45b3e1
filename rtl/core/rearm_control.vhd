-- SPDX-License-Identifier: Apache-2.0
--
-- # rearm_control
--
-- Changes counts_per_rev so that no unit uses the new number of counts with an angle that was counted with the old
-- number. On `rearm_command` the entity holds the decoders in `rearm`, at angle zero. When the pipelines contain no
-- other angle, it loads `requested` into counts_per_rev. A value outside 4 to 2²⁴ is refused: the decoders are held,
-- but counts_per_rev keeps its value.
--
-- **Latency.** `rearm` is high from the clock after the command for HOLD clocks; counts_per_rev changes in the middle
-- of this time. A command during this time restarts it.
--
-- **Number formats.** counts_per_rev u25.0 counts; requested u32.0 counts; all its bits are checked.
--
-- `changes_turn` is high with `rearm` if the requested number of counts is legal and differs from the present one. Then
-- the limit of the correction, half a turn, changes, and a correction beyond the new limit is clipped at once. While
-- `changes_turn` is high the output must not follow the position, because it would send the clipped difference as a
-- burst of edges.
--
-- **Clear semantics.** `refused` is set by a command with an illegal value and cleared by one with
-- a legal value.
--
-- **Reset.** counts_per_rev is 2²⁴, `refused` is cleared; `rearm` is low, since reset itself
-- re-arms the decoders.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.number_formats_pkg.all;

entity rearm_control is
  generic (
    -- Clocks of a re-arm: twice the latency of the pipeline with any FOLD, plus a margin for the units after the
    -- pipeline.
    HOLD : positive range 4 to 255 := 4 * (PIPELINE_LATENCY + 3)
  );
  port (
    clock          : in    std_ulogic;
    reset          : in    std_ulogic;
    rearm_command  : in    std_ulogic;                                    -- pulse: re-arm, and load requested
    requested      : in    u_unsigned(31 downto 0);                       -- counts
    counts_per_rev : out   u_unsigned(COUNTS_PER_REV_WIDTH - 1 downto 0); -- counts, the number in use
    rearm          : out   std_ulogic;                                    -- level: holds the decoders at angle zero
    changes_turn   : out   std_ulogic;                                    -- level with rearm: counts_per_rev changes
    refused        : out   std_ulogic                                     -- level: the value of the last command was illegal
  );
end entity rearm_control;

architecture rtl of rearm_control is

begin

  control : process (clock) is

    variable remaining : u_unsigned(7 downto 0) := (others => '0');
    -- The counts per turn that the last command requested, and whether this number is legal
    variable next_turn : u_unsigned(COUNTS_PER_REV_WIDTH - 1 downto 0);
    variable take      : std_ulogic := '0';
    variable legal     : std_ulogic;
    variable differs   : std_ulogic := '0';
    -- High while more than one clock of the hold is left.
    variable goes_on   : std_ulogic := '0';

  begin

    if rising_edge(clock) then
      legal := or requested(COUNTS_PER_REV_WIDTH - 2 downto 2);
      if (or requested(requested'high downto COUNTS_PER_REV_WIDTH - 1)) = '1' then
        legal := requested ?= COUNTS_PER_REV_MAX;
      end if;

      if remaining = HOLD / 2 and take = '1' then
        counts_per_rev <= next_turn;
      end if;

      rearm        <= '0';
      changes_turn <= '0';
      if rearm_command = '1' then
        remaining := to_unsigned(HOLD, 8);
        next_turn := resize(requested, COUNTS_PER_REV_WIDTH);
        take      := legal;
        refused   <= not legal;
        rearm     <= '1';

        differs := '0';
        if requested /= counts_per_rev then
          differs := legal;
        end if;
        changes_turn <= differs;
      elsif remaining /= 0 then
        remaining := remaining - 1;
        rearm     <= goes_on;

        changes_turn <= differs and goes_on;
      end if;

      if reset = '1' then
        remaining      := (others => '0');
        rearm          <= '0';
        changes_turn   <= '0';
        refused        <= '0';
        counts_per_rev <= to_unsigned(COUNTS_PER_REV_MAX, COUNTS_PER_REV_WIDTH);
      end if;
      goes_on := or remaining(7 downto 1);
    end if;

  end process control;

end architecture rtl;
