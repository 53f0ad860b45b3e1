-- SPDX-License-Identifier: Apache-2.0
--
-- # bank_swap
--
-- Decides when a swap of the two banks of coefficients takes place, and states which bank and which slot each output of
-- coefficient_memory reads, so that all coefficients of one angle come from one bank.
--
-- **Swap.** A pulse of `swap` waits until `ready` and `swap_allowed` are high in the same clock; several waiting swaps
-- count as one. `takes_place` is high in the clock of the swap, `marker` in the next clock, that of the first angle of
-- the new bank.
--
-- **One bank for one angle.** The phase steps change their bank with `marker`, the phase offsets PHASE_OFFSET_DELAY
-- clocks after `takes_place`, the amplitudes AMPLITUDE_DELAY clocks and the offset OFFSET_DELAY clocks after it. `ends`
-- is high when the last of them has changed; from then on the idle bank may be written.
--
-- **Latency.** Bank and slot of an output belong to the clock before its words, because coefficient_banks has an output
-- register.
--
-- **Number formats.** A bank is one bit; a slot is the number of a block of lanes, 0 to FOLD - 1, as `slot`.
--
-- **Reset.** `reset` drops a swap that waits, because it clears what belongs to this swap in other entities, too: later
-- the swap would activate lanes without the local table. A swap that has taken place ends, because otherwise parts of
-- two banks would stay active together.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

entity bank_swap is
  generic (
    FOLD               : positive range 1 to 8;  -- number of lanes that share a pipeline: 1, 2, 4 or 8
    PHASE_OFFSET_DELAY : positive range 1 to 63; -- clocks
    AMPLITUDE_DELAY    : positive range 1 to 63; -- clocks
    OFFSET_DELAY       : positive range 1 to 63  -- clocks
  );
  port (
    clock          : in    std_ulogic;
    reset          : in    std_ulogic;
    swap           : in    std_ulogic;                                -- pulse: the idle bank becomes active
    swap_allowed   : in    std_ulogic;                                -- high if the next clock brings a new angle
    ready          : in    std_ulogic;                                -- high if the idle bank is complete
    slot           : in    u_unsigned(2 downto 0);                    -- number of the block of lanes; 0 with a new angle
    waits          : out   std_ulogic := '0';                         -- level: a swap waits
    takes_place    : out   std_ulogic;                                -- high in the clock of a swap
    marker         : out   std_ulogic;                                -- high with the first angle of a new bank
    under_way      : out   std_ulogic;                                -- level: from takes_place to ends
    offset_changes : out   std_ulogic;                                -- strobe: the offset changes its bank after this clock
    ends           : out   std_ulogic;                                -- strobe: no output reads the idle bank any more
    active         : out   std_ulogic := '0';                         -- the active bank
    step_bank      : out   std_ulogic;
    step_slot      : out   u_unsigned(2 downto 0);
    phase_bank     : out   std_ulogic := '0';
    phase_slot     : out   u_unsigned(2 downto 0);
    amplitude_bank : out   std_ulogic := '0';
    amplitude_slot : out   u_unsigned(2 downto 0)
  );
end entity bank_swap;

architecture rtl of bank_swap is

  constant LAST_COPY : positive := maximum(maximum(PHASE_OFFSET_DELAY, AMPLITUDE_DELAY), OFFSET_DELAY);

  subtype slot_number is u_unsigned(2 downto 0);

  -- Returns the slot `ahead` clocks after `now`.
  function later (now : slot_number; ahead : integer) return slot_number is
  begin

    return (now + (ahead mod FOLD)) and to_unsigned(FOLD - 1, 3);

  end function later;

  -- Bank and slot of the words that the outputs show in the next clock. Initial values are the state at power-up.
  signal slot_of_phase     : slot_number := later("000", 1 - PHASE_OFFSET_DELAY);
  signal slot_of_amplitude : slot_number := later("000", 1 - AMPLITUDE_DELAY);

  signal may_swap : std_ulogic;

  -- swapped(d) is high d clocks after a swap.
  signal swapped : std_ulogic_vector(0 to LAST_COPY);
  signal copying : std_ulogic_vector(1 to LAST_COPY) := (others => '0');

begin

  may_swap       <= swap_allowed and ready;
  takes_place    <= (swap or waits) and may_swap;
  swapped        <= takes_place & copying;
  marker         <= copying(1);
  under_way      <= takes_place or (or copying);
  offset_changes <= copying(OFFSET_DELAY);
  ends           <= copying(LAST_COPY);

  step_bank <= not active when takes_place = '1' else
               active;
  step_slot <= later(slot, 1);

  phase_slot     <= slot_of_phase;
  amplitude_slot <= slot_of_amplitude;

  swapping : process (clock) is
  begin

    if rising_edge(clock) then
      copying <= swapped(0 to LAST_COPY - 1);
      waits   <= (swap or waits) and not may_swap;
      if reset = '1' then
        waits <= '0';
      end if;

      if takes_place = '1' then
        active <= not active;
      end if;
      -- Phase offsets and amplitudes take the bank number of the phase steps, so that after a swap all three use the
      -- same bank.
      if swapped(PHASE_OFFSET_DELAY - 1) = '1' then
        phase_bank <= step_bank;
      end if;
      if swapped(AMPLITUDE_DELAY - 1) = '1' then
        amplitude_bank <= step_bank;
      end if;
      slot_of_phase     <= later(slot, 2 - PHASE_OFFSET_DELAY);
      slot_of_amplitude <= later(slot, 2 - AMPLITUDE_DELAY);
    end if;

  end process swapping;

end architecture rtl;
