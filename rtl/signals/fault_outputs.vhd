-- SPDX-License-Identifier: Apache-2.0
--
-- # fault_outputs
--
-- What the outside learns of a fault: the alarm pin, and the enable of the line drivers, which a fault can take away, so
-- that a drive sees a broken encoder in place of one that stands.
--
-- **Latency.** 1 clock.
--
-- **Alarm.** `alarm` is high while a fault is `present` whose bit in `alarm_sources` is set.
--
-- **Driver enable.** `driver_enable` is high while `enable` is, until a fault is `present` whose bit in `release_sources` is
-- set. From then on it is low, and `released` high, until `clear` (pulse) or a low `enable` while no such fault is
-- present: a fault that is over does not bring a moving encoder back by itself.
--
-- **Reset** takes the enable and the alarm away, and forgets the release.

library ieee;
  use ieee.std_logic_1164.all;

entity fault_outputs is
  generic (
    KINDS : positive := 5 -- of faults
  );
  port (
    clock           : in    std_ulogic;
    reset           : in    std_ulogic;
    enable          : in    std_ulogic;                            -- level: the output is in use
    clear           : in    std_ulogic;                            -- pulse: ends `released`
    present         : in    std_ulogic_vector(KINDS - 1 downto 0); -- faults, levels
    alarm_sources   : in    std_ulogic_vector(KINDS - 1 downto 0); -- faults that raise the alarm
    release_sources : in    std_ulogic_vector(KINDS - 1 downto 0); -- faults that release the outputs
    released        : out   std_ulogic := '0';                     -- level, sticky
    driver_enable   : out   std_ulogic := '0';                     -- pin
    alarm           : out   std_ulogic := '0'                      -- pin
  );
end entity fault_outputs;

architecture rtl of fault_outputs is

begin

  tell : process (clock) is

    variable is_fatal : std_ulogic;

  begin

    if rising_edge(clock) then
      is_fatal      := or (present and release_sources);
      released      <= enable and (is_fatal or (released and not clear));
      driver_enable <= enable and not is_fatal and (clear or not released);
      alarm         <= or (present and alarm_sources);

      if reset = '1' then
        released      <= '0';
        driver_enable <= '0';
        alarm         <= '0';
      end if;
    end if;

  end process tell;

end architecture rtl;
