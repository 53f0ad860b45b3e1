// SPDX-License-Identifier: Apache-2.0
//
// Handshake rules of AXI3 and AXI4-Lite (AMBA AXI, issue D, A3.2.1) at axi3_to_axi_lite: what is
// valid stays valid and unchanged until it is taken. Whatever the master does; the slave answers a
// write only after it has taken address and data (A3.3.1).

module axi3_to_axi_lite_rules (
    input clock, input reset,
    input s_axi_awvalid, input [11:0] s_axi_awid, input [31:0] s_axi_awaddr,
    input [3:0] s_axi_awlen, input [2:0] s_axi_awsize, input [1:0] s_axi_awburst,
    input s_axi_wvalid, input [31:0] s_axi_wdata, input [3:0] s_axi_wstrb, input s_axi_wlast,
    input s_axi_bready,
    input s_axi_arvalid, input [11:0] s_axi_arid, input [31:0] s_axi_araddr,
    input [3:0] s_axi_arlen, input [2:0] s_axi_arsize, input [1:0] s_axi_arburst,
    input s_axi_rready,
    input m_axil_awready, input m_axil_wready, input m_axil_bvalid, input [1:0] m_axil_bresp,
    input m_axil_arready, input m_axil_rvalid, input [31:0] m_axil_rdata, input [1:0] m_axil_rresp
);

    wire s_axi_bvalid, s_axi_rvalid, s_axi_rlast, m_axil_awvalid, m_axil_wvalid, m_axil_arvalid;
    wire s_axi_awready, s_axi_wready, s_axi_arready, m_axil_bready, m_axil_rready;
    wire [11:0] s_axi_bid, s_axi_rid;
    wire [1:0] s_axi_bresp, s_axi_rresp;
    wire [31:0] s_axi_rdata, m_axil_wdata;
    wire [17:0] m_axil_awaddr, m_axil_araddr;
    wire [3:0] m_axil_wstrb;

    axi3_to_axi_lite bridge (.*);

    reg running = 0;
    reg aw_waits = 0, w_waits = 0, ar_waits = 0, b_waits = 0, r_waits = 0;
    reg [17:0] aw_before, ar_before;
    reg [35:0] w_before;
    reg [13:0] b_before;
    reg [46:0] r_before;
    wire [35:0] w = {m_axil_wdata, m_axil_wstrb};
    wire [13:0] b = {s_axi_bid, s_axi_bresp};
    wire [46:0] r = {s_axi_rid, s_axi_rresp, s_axi_rlast, s_axi_rdata};

    always @(posedge clock) begin
        running <= 1;
        aw_waits <= !reset && m_axil_awvalid && !m_axil_awready;
        w_waits <= !reset && m_axil_wvalid && !m_axil_wready;
        ar_waits <= !reset && m_axil_arvalid && !m_axil_arready;
        b_waits <= !reset && s_axi_bvalid && !s_axi_bready;
        r_waits <= !reset && s_axi_rvalid && !s_axi_rready;
        aw_before <= m_axil_awaddr;
        w_before <= w;
        ar_before <= m_axil_araddr;
        b_before <= b;
        r_before <= r;
    end

    always @* begin
        assume (running || reset);
        assume (!m_axil_bvalid || !(m_axil_awvalid || m_axil_wvalid));
        if (running) begin
            assert (!aw_waits || (m_axil_awvalid && m_axil_awaddr == aw_before));
            assert (!w_waits || (m_axil_wvalid && w == w_before));
            assert (!ar_waits || (m_axil_arvalid && m_axil_araddr == ar_before));
            assert (!b_waits || (s_axi_bvalid && b == b_before));
            assert (!r_waits || (s_axi_rvalid && r == r_before));
            // One access at a time: an address or data out there belongs to the answer waited for.
            assert (!(m_axil_awvalid || m_axil_wvalid) || m_axil_bready);
        end
    end

endmodule
