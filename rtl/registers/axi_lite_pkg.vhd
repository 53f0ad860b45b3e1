-- SPDX-License-Identifier: Apache-2.0
--
-- # axi_lite_pkg
--
-- Declares the AXI4-Lite bus of the registers as two records, one per direction, with the signal names of the AMBA AXI
-- protocol specification, issue D, chapter B1. The records omit AWPROT and ARPROT, because no unit reads them.

library ieee;
  use ieee.std_logic_1164.all;

package axi_lite_pkg is

  -- Width of a byte address: the register map has 512 KiB.
  constant AXI_LITE_ADDRESS_WIDTH : positive := 19;

  subtype axi_lite_address is std_ulogic_vector(AXI_LITE_ADDRESS_WIDTH - 1 downto 0);

  -- Signals from the master to the slave.
  type axi_lite_request is record
    awvalid : std_ulogic;
    awaddr  : axi_lite_address; -- bytes
    wvalid  : std_ulogic;
    wdata   : std_ulogic_vector(31 downto 0);
    wstrb   : std_ulogic_vector(3 downto 0);
    bready  : std_ulogic;
    arvalid : std_ulogic;
    araddr  : axi_lite_address; -- bytes
    rready  : std_ulogic;
  end record axi_lite_request;

  -- Signals from the slave to the master.
  type axi_lite_response is record
    awready : std_ulogic;
    wready  : std_ulogic;
    bvalid  : std_ulogic;
    bresp   : std_ulogic_vector(1 downto 0);
    arready : std_ulogic;
    rvalid  : std_ulogic;
    rdata   : std_ulogic_vector(31 downto 0);
    rresp   : std_ulogic_vector(1 downto 0);
  end record axi_lite_response;

end package axi_lite_pkg;
