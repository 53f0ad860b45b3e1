-- SPDX-License-Identifier: Apache-2.0
--
-- # axi3_to_axi_lite
--
-- Splits the AXI3 bursts of a processor port (M_AXI_GP0 of the Zynq-7000) into single AXI4-Lite accesses. A burst has
-- up to 16 beats, the kind FIXED, INCR or WRAP, and an ID; its beats may be narrower than the bus. Source: AMBA AXI
-- protocol specification, issue D, chapters A3 to A5.
--
-- **Latency.** If the slave accepts each request at once and answers in the next clock, a read beat takes 4 clocks and
-- a write beat 3; a burst takes 1 clock more for its address, and a write burst 1 clock more for its response. Reads
-- and writes do not wait for each other. In each direction the entity handles one burst at a time, so answers come in
-- order; they carry the ID of their burst.
--
-- **Number formats.** Addresses are in bytes; `size` is log2 of the number of bytes in a beat; `len` is the number of
-- beats minus 1.
--
-- **Beats.** A read beat reads the whole word that contains its address. A write beat is passed on with its strobes; a
-- write beat without any strobe makes no access. An INCR burst must not cross a 4 KiB boundary, so only the lower 12
-- address bits change within it.
--
-- **Errors.** The response to a write burst is the first response among its beats that is not OKAY, or else OKAY; every
-- read beat carries its own response. The entity makes no access and answers SLVERR if the burst kind is 3, if `size`
-- is above 2, or if a WRAP burst is not 2, 4, 8 or 16 beats long or does not start at a multiple of the bytes of a
-- beat. Otherwise it makes no access and answers DECERR if the first address is outside of BASE .. BASE +
-- 2**AXI_LITE_ADDRESS_WIDTH - 1. It accepts AWLEN + 1 write beats, and answers SLVERR if WLAST is not high with the
-- last of these beats, or is high with an earlier one. It answers OKAY to an exclusive access, which tells the master
-- that there is no exclusive monitor.
--
-- **Reset** drops a burst in progress, so master and slave must be reset together with the entity. A burst that is
-- requested during the reset waits, because the entity then accepts no address.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

  use work.axi_lite_pkg.all;

entity axi3_to_axi_lite is
  generic (
    ID_WIDTH : positive range 1 to 16 := 12;
    BASE     : natural                := 16#4000_0000# -- bytes, a multiple of 2**AXI_LITE_ADDRESS_WIDTH
  );
  port (
    clock           : in    std_ulogic;
    reset           : in    std_ulogic;
    -- AXI3 slave, 32 bit
    s_axi_awvalid   : in    std_ulogic;
    s_axi_awready   : out   std_ulogic;
    s_axi_awid      : in    std_ulogic_vector(ID_WIDTH - 1 downto 0);
    s_axi_awaddr    : in    std_ulogic_vector(31 downto 0); -- bytes
    s_axi_awlen     : in    std_ulogic_vector(3 downto 0);  -- beats - 1
    s_axi_awsize    : in    std_ulogic_vector(2 downto 0);  -- log2 of bytes
    s_axi_awburst   : in    std_ulogic_vector(1 downto 0);  -- 0 FIXED, 1 INCR, 2 WRAP
    s_axi_wvalid    : in    std_ulogic;
    s_axi_wready    : out   std_ulogic;
    s_axi_wdata     : in    std_ulogic_vector(31 downto 0);
    s_axi_wstrb     : in    std_ulogic_vector(3 downto 0);
    s_axi_wlast     : in    std_ulogic;
    s_axi_bvalid    : out   std_ulogic;
    s_axi_bready    : in    std_ulogic;
    s_axi_bid       : out   std_ulogic_vector(ID_WIDTH - 1 downto 0);
    s_axi_bresp     : out   std_ulogic_vector(1 downto 0);
    s_axi_arvalid   : in    std_ulogic;
    s_axi_arready   : out   std_ulogic;
    s_axi_arid      : in    std_ulogic_vector(ID_WIDTH - 1 downto 0);
    s_axi_araddr    : in    std_ulogic_vector(31 downto 0); -- bytes
    s_axi_arlen     : in    std_ulogic_vector(3 downto 0);  -- beats - 1
    s_axi_arsize    : in    std_ulogic_vector(2 downto 0);  -- log2 of bytes
    s_axi_arburst   : in    std_ulogic_vector(1 downto 0);  -- 0 FIXED, 1 INCR, 2 WRAP
    s_axi_rvalid    : out   std_ulogic;
    s_axi_rready    : in    std_ulogic;
    s_axi_rid       : out   std_ulogic_vector(ID_WIDTH - 1 downto 0);
    s_axi_rdata     : out   std_ulogic_vector(31 downto 0);
    s_axi_rresp     : out   std_ulogic_vector(1 downto 0);
    s_axi_rlast     : out   std_ulogic;
    -- AXI4-Lite master, see axi_lite_pkg
    m_axil_request  : out   axi_lite_request;
    m_axil_response : in    axi_lite_response
  );
end entity axi3_to_axi_lite;

architecture rtl of axi3_to_axi_lite is

  constant OKAY   : std_ulogic_vector(1 downto 0) := "00";
  constant SLVERR : std_ulogic_vector(1 downto 0) := "10";
  constant DECERR : std_ulogic_vector(1 downto 0) := "11";

  constant WRAP : std_ulogic_vector(1 downto 0) := "10";

  -- A burst stays within an aligned block of 4 KiB, so only these address bits change.
  constant PAGE_WIDTH : positive := 12;
  -- A WRAP burst has at most 16 beats of 4 bytes, which are 2**6 bytes.
  constant WRAP_WIDTH : positive := 6;

  constant BASE_ADDRESS : u_unsigned(31 downto 0) := to_unsigned(BASE, 32);

  type write_state is (WRITE_IDLE, WRITE_BEAT, WRITE_ACCESS, WRITE_ANSWER);

  type read_state is (READ_IDLE, READ_BEAT, READ_ADDRESS, READ_DATA, READ_ANSWER);

  type burst is record
    address : u_unsigned(31 downto 0);
    beats   : u_unsigned(3 downto 0);                     -- number of beats after this one
    size    : u_unsigned(1 downto 0);
    kind    : std_ulogic_vector(1 downto 0);
    mask    : u_unsigned(WRAP_WIDTH - 1 downto 0);        -- address bits that a WRAP burst changes
    refusal : std_ulogic_vector(1 downto 0);              -- response without an access; OKAY: no refusal
  end record burst;

  function in_window (
    address : std_ulogic_vector(31 downto 0)
  ) return boolean is
  begin

    return u_unsigned(address(31 downto AXI_LITE_ADDRESS_WIDTH)) = BASE_ADDRESS(31 downto AXI_LITE_ADDRESS_WIDTH);

  end function in_window;

  function started (
    address : std_ulogic_vector(31 downto 0);
    len     : std_ulogic_vector(3 downto 0);
    size    : std_ulogic_vector(2 downto 0);
    kind    : std_ulogic_vector(1 downto 0)
  ) return burst is

    variable result     : burst;
    variable unit       : u_unsigned(WRAP_WIDTH - 1 downto 0);
    variable wrap_bytes : u_unsigned(WRAP_WIDTH - 1 downto 0);

  begin

    result.address := u_unsigned(address);
    result.beats   := u_unsigned(len);
    result.size    := u_unsigned(size(1 downto 0));
    result.kind    := kind;
    result.refusal := OKAY;

    case size(1 downto 0) is

      when "00" =>
        unit       := to_unsigned(0, WRAP_WIDTH);
        wrap_bytes := "00" & u_unsigned(len);

      when "01" =>
        unit       := to_unsigned(1, WRAP_WIDTH);
        wrap_bytes := '0' & u_unsigned(len) & '1';

      when others =>
        unit       := to_unsigned(3, WRAP_WIDTH);
        wrap_bytes := u_unsigned(len) & "11";

    end case;

    result.mask := wrap_bytes;

    if not in_window(address) then
      result.refusal := DECERR;
    end if;
    if kind = "11" or u_unsigned(size) > 2
       or (kind = WRAP
           and ((u_unsigned(address(WRAP_WIDTH - 1 downto 0)) and unit) /= 0
                or (len /= "0001" and len /= "0011" and len /= "0111" and len /= "1111"))) then
      result.refusal := SLVERR;
    end if;

    return result;

  end function started;

  function following (
    now : burst
  ) return burst is

    variable result  : burst;
    variable aligned : u_unsigned(PAGE_WIDTH - 1 downto 0);
    variable step    : u_unsigned(2 downto 0);

  begin

    result       := now;
    result.beats := now.beats - 1;
    aligned      := now.address(PAGE_WIDTH - 1 downto 0);

    case now.size is

      when "00" =>
        step := "001";

      when "01" =>
        step       := "010";
        aligned(0) := '0';

      when others =>
        step                := "100";
        aligned(1 downto 0) := "00";

    end case;

    aligned := aligned + step;

    if now.kind = WRAP then
      result.address(WRAP_WIDTH - 1 downto 0) := (now.address(WRAP_WIDTH - 1 downto 0) and not now.mask)
                                                 or (aligned(WRAP_WIDTH - 1 downto 0) and now.mask);
    elsif now.kind(0) = '1' then
      result.address(PAGE_WIDTH - 1 downto 0) := aligned;
    end if;

    return result;

  end function following;

  signal writing    : write_state := WRITE_IDLE;
  signal write_now  : burst;
  signal write_resp : std_ulogic_vector(1 downto 0);
  signal reading    : read_state  := READ_IDLE;
  signal read_now   : burst;

begin

  assert BASE mod 2 ** AXI_LITE_ADDRESS_WIDTH = 0
    report "axi3_to_axi_lite: BASE must be a multiple of 2**AXI_LITE_ADDRESS_WIDTH"
    severity failure;

  s_axi_awready <= '1' when writing = WRITE_IDLE and reset = '0' else
                   '0';
  s_axi_wready  <= '1' when writing = WRITE_BEAT else
                   '0';
  s_axi_bvalid  <= '1' when writing = WRITE_ANSWER else
                   '0';
  s_axi_bresp   <= write_resp;
  m_axil_request.bready <= '1' when writing = WRITE_ACCESS else
                   '0';

  write_burst : process (clock) is

    variable answer : std_ulogic_vector(1 downto 0);
    variable last   : boolean;
    variable done   : boolean;

  begin

    if rising_edge(clock) then
      done := false;
      last := write_now.beats = 0;

      case writing is

        when WRITE_IDLE =>
          write_now  <= started(s_axi_awaddr, s_axi_awlen, s_axi_awsize, s_axi_awburst);
          write_resp <= OKAY;
          s_axi_bid  <= s_axi_awid;
          if s_axi_awvalid = '1' then
            writing <= WRITE_BEAT;
          end if;

        when WRITE_BEAT =>
          m_axil_request.awaddr <= std_ulogic_vector(write_now.address(AXI_LITE_ADDRESS_WIDTH - 1 downto 2)) & "00";
          m_axil_request.wdata  <= s_axi_wdata;
          m_axil_request.wstrb  <= s_axi_wstrb;
          if s_axi_wvalid = '1' then
            answer := write_now.refusal;
            if (s_axi_wlast = '1') /= last then
              answer := SLVERR;
            end if;
            if write_resp = OKAY then
              write_resp <= answer;
            end if;
            if write_now.refusal = OKAY and s_axi_wstrb /= "0000" then
              m_axil_request.awvalid <= '1';
              m_axil_request.wvalid  <= '1';
              writing        <= WRITE_ACCESS;
            else
              done := true;
            end if;
          end if;

        when WRITE_ACCESS =>
          if m_axil_response.awready = '1' then
            m_axil_request.awvalid <= '0';
          end if;
          if m_axil_response.wready = '1' then
            m_axil_request.wvalid <= '0';
          end if;
          if m_axil_response.bvalid = '1' then
            if write_resp = OKAY then
              write_resp <= m_axil_response.bresp;
            end if;
            done := true;
          end if;

        when WRITE_ANSWER =>
          if s_axi_bready = '1' then
            writing <= WRITE_IDLE;
          end if;

      end case;

      if done then
        if last then
          writing <= WRITE_ANSWER;
        else
          write_now <= following(write_now);
          writing   <= WRITE_BEAT;
        end if;
      end if;

      if reset = '1' then
        writing        <= WRITE_IDLE;
        m_axil_request.awvalid <= '0';
        m_axil_request.wvalid  <= '0';
      end if;
    end if;

  end process write_burst;

  s_axi_arready  <= '1' when reading = READ_IDLE and reset = '0' else
                    '0';
  s_axi_rvalid   <= '1' when reading = READ_ANSWER else
                    '0';
  m_axil_request.arvalid <= '1' when reading = READ_ADDRESS else
                    '0';
  m_axil_request.rready  <= '1' when reading = READ_DATA else
                    '0';
  m_axil_request.araddr  <= std_ulogic_vector(read_now.address(AXI_LITE_ADDRESS_WIDTH - 1 downto 2)) & "00";

  read_burst : process (clock) is
  begin

    if rising_edge(clock) then

      case reading is

        when READ_IDLE =>
          read_now  <= started(s_axi_araddr, s_axi_arlen, s_axi_arsize, s_axi_arburst);
          s_axi_rid <= s_axi_arid;
          if s_axi_arvalid = '1' then
            reading <= READ_BEAT;
          end if;

        when READ_BEAT =>
          s_axi_rdata <= (others => '0');
          s_axi_rresp <= read_now.refusal;
          s_axi_rlast <= '0';
          if read_now.beats = 0 then
            s_axi_rlast <= '1';
          end if;
          if read_now.refusal = OKAY then
            reading <= READ_ADDRESS;
          else
            reading <= READ_ANSWER;
          end if;

        when READ_ADDRESS =>
          if m_axil_response.arready = '1' then
            reading <= READ_DATA;
          end if;

        when READ_DATA =>
          s_axi_rdata <= m_axil_response.rdata;
          s_axi_rresp <= m_axil_response.rresp;
          if m_axil_response.rvalid = '1' then
            reading <= READ_ANSWER;
          end if;

        when READ_ANSWER =>
          if s_axi_rready = '1' then
            read_now <= following(read_now);
            if s_axi_rlast = '1' then
              reading <= READ_IDLE;
            else
              reading <= READ_BEAT;
            end if;
          end if;

      end case;

      if reset = '1' then
        reading <= READ_IDLE;
      end if;
    end if;

  end process read_burst;

end architecture rtl;
