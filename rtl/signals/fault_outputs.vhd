-- SPDX-License-Identifier: Apache-2.0
--
-- # fault_outputs
--
-- Reports faults at two pins, `alarm` and `driver_enable`. A fault that `release_sources` selects switches
-- `driver_enable` off: the drive that reads the encoder then detects a broken encoder. Without this, the drive could
-- interpret signals that no longer change as a table that stands still.
--
-- **Latency.** The outputs follow the inputs by 1 clock, except `clear`, which they follow by 2 clocks.
--
-- **Alarm.** `alarm` is high while a bit is high in both `present` and `alarm_sources`.
--
-- **Driver enable.** `driver_enable` is high while `enable` is high, until a fault releases the drivers: a bit is high
-- in both `present` and `release_sources`. From then on `driver_enable` is low and `released` is high, until `enable`
-- is low, or until no such fault is present one clock after a pulse of `clear`. So one pulse can clear both the fault
-- and the release, a fault that persists keeps the drivers released, and the end of a fault alone does not enable the
-- drivers again. `causes` shows the faults that released the drivers and the faults that came later; after a `clear`
-- that did not end the release, it shows the faults that are still present.
--
-- **Reset** clears the alarm and the release, and holds `driver_enable` at its level: so a reset of the core, during
-- which A and B do not change, does not trip a drive that monitors its lines. `enable` falls with the reset. The hold
-- of `driver_enable` ends when `enable` is high again; `driver_enable` then stays high without a gap. If `enable` stays
-- low, the hold ends 2**HOLD_LOG2 clocks after the first clock of the reset: `driver_enable` then falls, so that the
-- drivers release the lines if the processor does not set up the output again. Drivers that were released before the
-- reset stay released until `enable` is high. A reset within a hold does not prolong the hold.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

entity fault_outputs is
  generic (
    KINDS     : positive              := 6; -- number of kinds of faults
    HOLD_LOG2 : positive range 1 to 30 := 20 -- log2 of the clocks for which a reset keeps driver_enable
  );
  port (
    clock           : in    std_ulogic;
    reset           : in    std_ulogic;
    enable          : in    std_ulogic;                            -- level: the output is in use
    clear           : in    std_ulogic;                            -- pulse: ends `released`
    present         : in    std_ulogic_vector(KINDS - 1 downto 0); -- faults, levels
    alarm_sources   : in    std_ulogic_vector(KINDS - 1 downto 0); -- faults that raise the alarm
    release_sources : in    std_ulogic_vector(KINDS - 1 downto 0); -- faults that release the drivers
    released        : out   std_ulogic := '0';                     -- level, sticky
    causes          : out   std_ulogic_vector(KINDS - 1 downto 0) := (others => '0'); -- faults that caused or followed `released`
    driver_enable   : out   std_ulogic := '0';                     -- pin
    alarm           : out   std_ulogic := '0'                      -- pin
  );
end entity fault_outputs;

architecture rtl of fault_outputs is

begin

  tell : process (clock) is

    variable fatal    : std_ulogic_vector(KINDS - 1 downto 0);
    -- `clear` of one clock ago: a fault that this pulse has cleared in another unit is no longer present now.
    variable cleared  : std_ulogic := '0';
    -- `held` is the number of clocks of the hold so far; its highest bit is set when the hold is over. `resets` is the
    -- reset one clock ago.
    variable held     : u_unsigned(HOLD_LOG2 downto 0) := '1' & (HOLD_LOG2 - 1 downto 0 => '0');
    variable resets   : std_ulogic := '0';

  begin

    if rising_edge(clock) then
      fatal         := present and release_sources;
      released      <= enable and (or fatal or (released and not cleared));
      causes        <= (fatal or (causes and (causes'range => not cleared))) and (causes'range => enable);
      if held(HOLD_LOG2) = '0' then
        held := held + 1;
      elsif reset = '1' and resets = '0' then
        held := (others => '0');
      end if;
      if enable = '1' and reset = '0' then
        held(HOLD_LOG2) := '1';
      end if;
      resets := reset;

      -- During a hold the output does not change.
      if held(HOLD_LOG2) = '1' then
        driver_enable <= enable and not (or fatal) and (cleared or not released) and not reset;
      end if;
      alarm         <= or (present and alarm_sources);

      cleared := clear;
      if reset = '1' then
        cleared       := '0';
        released      <= '0';
        causes        <= (others => '0');
        alarm         <= '0';
      end if;
    end if;

  end process tell;

end architecture rtl;
