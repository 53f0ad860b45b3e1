-- SPDX-License-Identifier: Apache-2.0
--
-- # access_guard
--
-- Stands before the generated register block and sends every access that only this core's
-- generics or state make illegal to an unmapped address, so that the block answers it with
-- `SLVERR`: a coefficient word of a lane that is not built, a write of a coefficient or of the
-- coefficient offset without all four bytes, a capture word beyond the two words of every sample
-- of a bank, and any capture word while no bank is ready.
--
-- **Latency.** None: there is no register in it. A write address is passed on together with its
-- data, so that the byte strobes can be judged with it; AXI4-Lite lets a slave wait for both.
--
-- **Number formats.** Addresses in bytes.
--
-- **Reset.** Holds no state.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.number_formats_pkg.all;
  use work.register_addresses_pkg.all;

entity access_guard is
  generic (
    LANES         : positive range 1 to LANES_MAX := LANES_DEFAULT;
    CAPTURE_DEPTH : positive range 2 to 16384     := CAPTURE_DEPTH_DEFAULT
  );
  port (
    capture_ready : in    std_ulogic;                      -- a bank belongs to the processor
    -- From and to the bus.
    awvalid       : in    std_ulogic;
    awready       : out   std_ulogic;
    awaddr        : in    std_ulogic_vector(17 downto 0);  -- bytes
    wvalid        : in    std_ulogic;
    wready        : out   std_ulogic;
    wstrb         : in    std_ulogic_vector(3 downto 0);
    araddr        : in    std_ulogic_vector(17 downto 0);  -- bytes
    -- To and from the register block.
    block_awvalid : out   std_ulogic;
    block_awready : in    std_ulogic;
    block_awaddr  : out   std_ulogic_vector(17 downto 0);  -- bytes
    block_wvalid  : out   std_ulogic;
    block_wready  : in    std_ulogic;
    block_araddr  : out   std_ulogic_vector(17 downto 0)   -- bytes
  );
end entity access_guard;

architecture rtl of access_guard is

  subtype byte_address is u_unsigned(17 downto 0);

  constant COEFFICIENTS_FIRST : byte_address := to_unsigned(COEFFICIENTS_ADDRESS, 18);
  constant CAPTURE_FIRST      : byte_address := to_unsigned(CAPTURE_ADDRESS, 18);
  constant OFFSET_WORD        : byte_address := to_unsigned(COEFFICIENT_OFFSET_ADDRESS, 18);
  constant UNMAPPED_WORD      : byte_address := to_unsigned(UNMAPPED_ADDRESS, 18);

  -- Windows are aligned to their size: 1 KiB of coefficients, 128 KiB of capture.

  function in_coefficients (
    address : byte_address
  ) return boolean is
  begin

    return address(17 downto 10) = COEFFICIENTS_FIRST(17 downto 10);

  end function in_coefficients;

  function is_refused (
    address : byte_address;
    ready   : std_ulogic
  ) return boolean is

    variable lane   : u_unsigned(5 downto 0);
    variable sample : u_unsigned(13 downto 0);

  begin

    lane   := address(9 downto 4);
    sample := address(16 downto 3);

    if in_coefficients(address) then
      return lane > LANES - 1;
    end if;
    if address(17) = CAPTURE_FIRST(17) then
      return ready = '0' or sample > CAPTURE_DEPTH - 1;
    end if;
    return false;

  end function is_refused;

begin

  assert CAPTURE_ADDRESS = 16#20000# and COEFFICIENTS_ADDRESS mod 1024 = 0
    report "access_guard: the windows of the register map have moved; adapt the decoding"
    severity failure;

  read_address : process (all) is
  begin

    block_araddr <= araddr;

    if is_refused(u_unsigned(araddr), capture_ready) then
      block_araddr <= std_ulogic_vector(UNMAPPED_WORD);
    end if;

  end process read_address;

  write_address : process (all) is

    variable address : byte_address;
    variable partial : boolean;

  begin

    address := u_unsigned(awaddr);
    partial := wstrb /= "1111";

    block_awaddr <= awaddr;

    if is_refused(address, capture_ready)
       or (partial and (in_coefficients(address) or address(17 downto 2) = OFFSET_WORD(17 downto 2))) then
      block_awaddr <= std_ulogic_vector(UNMAPPED_WORD);
    end if;

  end process write_address;

  -- The block takes a write's address and data in the same clock.
  block_awvalid <= awvalid and wvalid and block_wready;
  block_wvalid  <= awvalid and wvalid and block_awready;
  awready       <= block_awready and block_wready and awvalid and wvalid;
  wready        <= block_awready and block_wready and awvalid and wvalid;

end architecture rtl;
