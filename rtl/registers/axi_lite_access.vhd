-- SPDX-License-Identifier: Apache-2.0
--
-- # axi_lite_access
--
-- Serves one AXI4-Lite transfer at a time as a slave: it holds the transfer, gives a unit one clock to check the
-- transfer, and holds the response until the master accepts it. Source: AMBA AXI protocol specification, issue D,
-- chapters A3 and B1.
--
-- **Latency.** 3 clocks from `arvalid`, or `awvalid` and `wvalid`, to the response: the transfer is accepted and
-- checked in the 1st clock, the answer is requested in the 2nd and given in the 3rd. If the unit answers later, the
-- response comes later by the same number of clocks. If unit and master do not wait, a transfer takes 4 clocks.
--
-- **Number formats.** Addresses are in bytes.
--
-- **Order.** A write is accepted when its address and its data are both valid; both are accepted in the same clock. If
-- reads and writes wait at the same time, they alternate: a read waits for at most one write, and a write for at most
-- one read.
--
-- **Check.** `taken` is high in the first clock in which address, kind and strobes of a transfer are at the outputs;
-- these keep their values until the end of the transfer. `refused` is sampled in the next clock. A refused transfer is
-- answered with `SLVERR` and data 0.
--
-- **Answer.** For every transfer that is not refused, the addressed unit pulses `answered` once, together with `data`,
-- in the clock in which `refused` is sampled or in any later clock.
--
-- **Reset** drops the present transfer, so master and units must be reset with it. A transfer that is requested during
-- the reset waits until the end of the reset.

library ieee;
  use ieee.std_logic_1164.all;

  use work.axi_lite_pkg.all;

entity axi_lite_access is
  port (
    clock           : in    std_ulogic;
    reset           : in    std_ulogic;
    -- AXI4-Lite slave, see axi_lite_pkg
    s_axil_request  : in    axi_lite_request;
    s_axil_response : out   axi_lite_response;
    -- The present transfer
    taken           : out   std_ulogic;                    -- pulse: a new transfer
    address         : out   axi_lite_address;              -- bytes, a multiple of 4
    is_write        : out   std_ulogic := '0';
    write_data      : out   std_ulogic_vector(31 downto 0);
    write_strobes   : out   std_ulogic_vector(3 downto 0);  -- one bit per byte
    refused         : in    std_ulogic;                    -- valid in the clock after taken
    -- Answer to the present transfer
    answered        : in    std_ulogic;                    -- pulse: the unit has read or written the word
    data            : in    std_ulogic_vector(31 downto 0) -- word that was read; 0 if refused
  );
end entity axi_lite_access;

architecture rtl of axi_lite_access is

  type access_state is (IDLE, BUSY, ANSWER);

  signal state : access_state                  := IDLE;
  signal resp  : std_ulogic_vector(1 downto 0) := "00";

begin

  s_axil_response.awready <= taken and is_write;
  s_axil_response.wready  <= taken and is_write;
  s_axil_response.arready <= taken and not is_write;
  s_axil_response.bvalid  <= '1' when state = ANSWER and is_write = '1' else
                    '0';
  s_axil_response.rvalid  <= '1' when state = ANSWER and is_write = '0' else
                    '0';
  s_axil_response.bresp   <= resp;
  s_axil_response.rresp   <= resp;

  one_access : process (clock) is

    variable choose_write : std_ulogic;

  begin

    if rising_edge(clock) then
      taken <= '0';

      case state is

        when IDLE =>
          -- A request stays valid until its handshake, so it may be sampled one clock before the handshake. is_write
          -- still holds the kind of the last transfer: if a read and a write are requested, the kind that differs from
          -- the last transfer is taken.
          choose_write  := s_axil_request.awvalid and s_axil_request.wvalid and not (s_axil_request.arvalid and is_write);
          address       <= s_axil_request.araddr(s_axil_request.araddr'high downto 2) & "00";
          write_data    <= s_axil_request.wdata;
          write_strobes <= s_axil_request.wstrb;
          if choose_write = '1' then
            address <= s_axil_request.awaddr(s_axil_request.awaddr'high downto 2) & "00";
          end if;
          if (choose_write or s_axil_request.arvalid) = '1' then
            is_write <= choose_write;
            taken    <= '1';
            state    <= BUSY;
          end if;

        when BUSY =>
          if taken = '0' then
            s_axil_response.rdata <= data;
            resp         <= refused & '0'; -- SLVERR or OKAY
            if (refused or answered) = '1' then
              state <= ANSWER;
            end if;
          end if;

        when ANSWER =>
          if (is_write = '1' and s_axil_request.bready = '1') or (is_write = '0' and s_axil_request.rready = '1') then
            state <= IDLE;
          end if;

      end case;

      if reset = '1' then
        taken    <= '0';
        is_write <= '0';
        state <= IDLE;
      end if;
    end if;

  end process one_access;

end architecture rtl;
