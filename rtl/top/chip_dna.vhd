-- SPDX-License-Identifier: Apache-2.0
--
-- # chip_dna
--
-- Reads the chip's fixed identifier (device DNA) from the primitive DNA_PORT, once after the reset, and outputs it from
-- then on. READ loads the identifier into the primitive's shift register, whose bit 56 is connected to DOUT; SHIFT
-- shifts the register, so that DOUT shows the next bit. Source: 7 series configuration user guide (UG470), chapter 5,
-- "Device DNA".
--
-- **Latency.** 116 × CLOCKS_PER_HALF clocks from the end of the reset to `known`.
--
-- **Number formats.** `dna` u57.0.
--
-- **Clock.** The primitive's clock comes from a register of this entity, which is high for CLOCKS_PER_HALF clocks and
-- low for CLOCKS_PER_HALF clocks. At the falling edge of this divided clock READ and SHIFT change and DOUT is sampled.
-- With `clock` at 100 MHz and CLOCKS_PER_HALF = 8 the divided clock has 6.25 MHz (up to 100 MHz are allowed), and each
-- path has half a period, 80 ns. constraints/vivado/chip_dna.xdc states this for Vivado.

library ieee;
  use ieee.std_logic_1164.all;

entity chip_dna is
  generic (
    CLOCKS_PER_HALF : positive range 1 to 256 := 8
  );
  port (
    clock : in    std_ulogic;
    reset : in    std_ulogic;
    dna   : out   std_ulogic_vector(56 downto 0);
    known : out   std_ulogic -- level: `dna` is complete
  );
end entity chip_dna;

architecture rtl of chip_dna is

  -- Primitive of the 7 series, named as the vendor's library names it.
  -- vsg_off
  component DNA_PORT is
    port (
      DOUT  : out   std_ulogic;
      CLK   : in    std_ulogic;
      DIN   : in    std_ulogic;
      READ  : in    std_ulogic;
      SHIFT : in    std_ulogic
    );
  end component DNA_PORT;
  -- vsg_on

  constant BITS : positive := 57;

  signal port_clock : std_ulogic;
  signal load       : std_ulogic;
  signal shift      : std_ulogic;
  signal bit_out    : std_ulogic;
  signal waited     : natural range 0 to CLOCKS_PER_HALF - 1;
  signal taken      : natural range 0 to BITS;
  signal identifier : std_ulogic_vector(BITS - 1 downto 0);

begin

  dna   <= identifier;
  known <= '1' when taken = BITS else
           '0';

  -- vsg_off
  dna_primitive : component DNA_PORT
    port map (
      DOUT  => bit_out,
      CLK   => port_clock,
      DIN   => '0',
      READ  => load,
      SHIFT => shift
    );
  -- vsg_on

  read_once : process (clock) is
  begin

    if rising_edge(clock) then
      if waited /= CLOCKS_PER_HALF - 1 then
        waited <= waited + 1;
      else
        waited <= 0;
        if taken /= BITS then
          port_clock <= not port_clock;
          if port_clock = '1' then
            -- The divided clock falls now. DOUT is a valid bit as soon as the identifier has been loaded.
            if load = '1' or shift = '1' then
              identifier <= identifier(BITS - 2 downto 0) & bit_out;
              taken      <= taken + 1;
            end if;
            load  <= not (load or shift);
            shift <= load or shift;
          end if;
        end if;
      end if;

      if reset = '1' then
        port_clock <= '0';
        load       <= '0';
        shift      <= '0';
        waited     <= 0;
        taken      <= 0;
      end if;
    end if;

  end process read_once;

end architecture rtl;
