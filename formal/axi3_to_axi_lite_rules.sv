// SPDX-License-Identifier: Apache-2.0
//
// Handshake rules of AXI3 and AXI4-Lite (AMBA AXI, issue D, A3.2.1) at axi3_to_axi_lite: a valid
// channel stays valid and unchanged until it is accepted, and no channel is valid after a reset (A3.1.2).
// Every burst gets exactly its responses: the requested beats, the last one marked, or one
// write response after its last beat, all with the ID of the burst (A3.3.1, A3.4.1, A5.3).
// The master may do anything; the slave answers a write only after it has accepted address and data.

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
    wire [18:0] m_axil_awaddr, m_axil_araddr;
    wire [3:0] m_axil_wstrb;

    axi3_to_axi_lite bridge (
        .*,
        .m_axil_request_awvalid(m_axil_awvalid), .m_axil_request_awaddr(m_axil_awaddr),
        .m_axil_request_wvalid(m_axil_wvalid), .m_axil_request_wdata(m_axil_wdata),
        .m_axil_request_wstrb(m_axil_wstrb), .m_axil_request_bready(m_axil_bready),
        .m_axil_request_arvalid(m_axil_arvalid), .m_axil_request_araddr(m_axil_araddr),
        .m_axil_request_rready(m_axil_rready),
        .m_axil_response_awready(m_axil_awready), .m_axil_response_wready(m_axil_wready),
        .m_axil_response_bvalid(m_axil_bvalid), .m_axil_response_bresp(m_axil_bresp),
        .m_axil_response_arready(m_axil_arready), .m_axil_response_rvalid(m_axil_rvalid),
        .m_axil_response_rdata(m_axil_rdata), .m_axil_response_rresp(m_axil_rresp)
    );

    reg running = 0;
    reg aw_waits = 0, w_waits = 0, ar_waits = 0, b_waits = 0, r_waits = 0;
    reg [18:0] aw_before, ar_before;
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

    // Bursts that the channels show: whether one is in progress, and the number of its beats so far.
    reg was_reset = 1;
    reg writes = 0, reads = 0;
    reg [4:0] written = 0, read = 0;
    reg [3:0] write_len = 0, read_len = 0;
    reg [11:0] write_id = 0, read_id = 0;

    always @(posedge clock) begin
        was_reset <= reset;
        if (s_axi_awvalid && s_axi_awready) begin
            writes <= 1;
            written <= 0;
            write_len <= s_axi_awlen;
            write_id <= s_axi_awid;
        end
        if (s_axi_wvalid && s_axi_wready) written <= written + 1;
        if (s_axi_bvalid && s_axi_bready) writes <= 0;
        if (s_axi_arvalid && s_axi_arready) begin
            reads <= 1;
            read <= 0;
            read_len <= s_axi_arlen;
            read_id <= s_axi_arid;
        end
        if (s_axi_rvalid && s_axi_rready) begin
            read <= read + 1;
            if (s_axi_rlast) reads <= 0;
        end
        if (reset) begin
            writes <= 0;
            reads <= 0;
        end
    end

    // The lemmas connect the number of beats that the entity still expects with the number counted here.
    wire [1:0] probe_writing;
    wire [2:0] probe_reading;
    wire [47:0] probe_write_now, probe_read_now;
    wire [3:0] write_left = probe_write_now[35:32];
    wire [3:0] read_left = probe_read_now[35:32];
    localparam WRITE_IDLE = 0, WRITE_BEAT = 1, WRITE_ACCESS = 2;
    localparam READ_IDLE = 0, READ_BEAT = 1, READ_ANSWER = 4;

    always @* begin
        assume (running || reset);
        assume (!m_axil_bvalid || !(m_axil_awvalid || m_axil_wvalid));
        if (running) begin
            assert (!aw_waits || (m_axil_awvalid && m_axil_awaddr == aw_before));
            assert (!w_waits || (m_axil_wvalid && w == w_before));
            assert (!ar_waits || (m_axil_arvalid && m_axil_araddr == ar_before));
            assert (!b_waits || (s_axi_bvalid && b == b_before));
            assert (!r_waits || (s_axi_rvalid && r == r_before));
            // One transfer at a time: a valid address or data belongs to the awaited response.
            assert (!(m_axil_awvalid || m_axil_wvalid) || m_axil_bready);

            assert (!was_reset || !(s_axi_bvalid || s_axi_rvalid || m_axil_awvalid
                                    || m_axil_wvalid || m_axil_arvalid));
            assert (!s_axi_awready || !writes);
            assert (!s_axi_wready || (writes && written <= write_len));
            assert (!s_axi_bvalid || (writes && written == write_len + 1 && s_axi_bid == write_id));
            assert (!s_axi_arready || !reads);
            assert (!s_axi_rvalid || (reads && s_axi_rid == read_id));
            assert (!s_axi_rvalid || s_axi_rlast == (read == read_len));

            // Lemmas.
            assert (writes == (probe_writing != WRITE_IDLE));
            assert (probe_writing != WRITE_BEAT || write_left == write_len - written);
            assert (probe_writing != WRITE_ACCESS || write_left == write_len + 1 - written);
            assert (probe_writing != WRITE_ACCESS || (written != 0 && written <= write_len + 1));
            assert (!writes || s_axi_bid == write_id);
            assert (reads == (probe_reading != READ_IDLE) && probe_reading <= READ_ANSWER);
            assert (!reads || (read <= read_len && read_left == read_len - read));
            assert (!reads || s_axi_rid == read_id);
            assert (!reads || probe_reading == READ_BEAT || s_axi_rlast == (read_left == 0));

            cover (s_axi_bvalid && write_len == 1 && s_axi_bresp == 0);
            cover (s_axi_rvalid && s_axi_rlast && read == 1 && s_axi_rresp == 0);
            cover (b_waits && r_waits);
            cover (aw_waits && !w_waits && m_axil_awready);
            cover (s_axi_rvalid && s_axi_rresp == 3);
        end
    end

endmodule
