// SPDX-License-Identifier: Apache-2.0
//
// AXI4-Lite rules (AMBA AXI, issue D, A3.1.2, A3.2.1, A3.3.1 and B1.1.1) at the core's port: answers
// stay valid and unchanged until they are taken, none is valid after a reset, each belongs to an
// access that was taken before it, and there is one for each. The master keeps to the same rules.
//
// Left out are the sampler, the compensation and all that calculates: what the registers read from
// them may be anything. Of the two that answer accesses themselves only this is assumed: a bank's
// word follows its read by 4 clocks (proven: sampler_rules), and a coefficient's acknowledge comes
// once for each write, later than it (proven: coefficient_memory_rules).

module arctrue_core_rules #(
    parameter LANES = 1, parameter CAPTURE_DEPTH = 2 // as the netlist
) (
    input clock, input reset,
    input awvalid, input [17:0] awaddr, input wvalid, input [31:0] wdata, input [3:0] wstrb,
    input bready, input arvalid, input [17:0] araddr, input rready
);

    wire awready, wready, bvalid, arready, rvalid;
    wire [1:0] bresp, rresp;
    wire [31:0] rdata;

    // Inputs that are not connected may take any value in any clock.
    arctrue_core core (
        .clock(clock), .reset(reset),
        .s_axil_awvalid(awvalid), .s_axil_awready(awready), .s_axil_awaddr(awaddr),
        .s_axil_wvalid(wvalid), .s_axil_wready(wready), .s_axil_wdata(wdata),
        .s_axil_wstrb(wstrb), .s_axil_bvalid(bvalid), .s_axil_bready(bready),
        .s_axil_bresp(bresp), .s_axil_arvalid(arvalid), .s_axil_arready(arready),
        .s_axil_araddr(araddr), .s_axil_rvalid(rvalid), .s_axil_rready(rready),
        .s_axil_rdata(rdata), .s_axil_rresp(rresp)
    );

    localparam OKAY = 0, SLVERR = 2;

    reg running = 0;
    reg was_reset = 1;
    reg aw_waits = 0, w_waits = 0, ar_waits = 0, b_waits = 0, r_waits = 0;
    reg [17:0] awaddr_before, araddr_before;
    reg [35:0] w_before;
    reg [1:0] bresp_before;
    reg [33:0] r_before;
    // Taken and not yet answered.
    reg [3:0] addresses = 0, data = 0, reads = 0;

    always @(posedge clock) begin
        running <= 1;
        was_reset <= reset;
        aw_waits <= !reset && awvalid && !awready;
        w_waits <= !reset && wvalid && !wready;
        ar_waits <= !reset && arvalid && !arready;
        b_waits <= !reset && bvalid && !bready;
        r_waits <= !reset && rvalid && !rready;
        awaddr_before <= awaddr;
        araddr_before <= araddr;
        w_before <= {wdata, wstrb};
        bresp_before <= bresp;
        r_before <= {rdata, rresp};
        addresses <= addresses + (awvalid && awready) - (bvalid && bready);
        data <= data + (wvalid && wready) - (bvalid && bready);
        reads <= reads + (arvalid && arready) - (rvalid && rready);
        if (reset) begin
            addresses <= 0;
            data <= 0;
            reads <= 0;
        end
    end

    // Accesses that another unit answers.
    wire probe_capture_read, probe_capture_valid, probe_write_acknowledge;
    wire probe_coefficient_request, probe_coefficient_write;
    wire probe_offset_request, probe_offset_write, probe_offset_is_written;
    wire probe_pending, probe_read_acknowledge, probe_external_read_acknowledge;
    wire [1:0] probe_read_under_way;
    wire probe_offset_read_acknowledge;
    reg [3:0] capture_reads = 0;
    reg [1:0] coefficient_reads = 0;
    reg offset_read = 0, write_waits = 0, offset_waits = 0;
    wire coefficient_read = probe_coefficient_request && !probe_coefficient_write;
    wire reads_offset = probe_offset_request && !probe_offset_write;
    wire writes_unit = probe_coefficient_write || probe_offset_write;

    always @(posedge clock) begin
        capture_reads <= {capture_reads, probe_capture_read};
        coefficient_reads <= {coefficient_reads, coefficient_read};
        offset_read <= reads_offset;
        if (probe_write_acknowledge) write_waits <= 0;
        if (writes_unit) begin
            write_waits <= 1;
            offset_waits <= probe_offset_write;
        end
        if (reset) begin
            capture_reads <= 0;
            coefficient_reads <= 0;
            offset_read <= 0;
            write_waits <= 0;
        end
    end

    // For the lemmas: what the register block holds of answers, and of accesses under way.
    wire [2:0] probe_written, probe_taken;
    wire [135:0] probe_answers;
    wire [1:0] probe_in_flight;
    wire probe_arvalid, probe_awvalid, probe_wvalid;
    wire [1:0] filled = probe_written[1:0] - probe_taken[1:0]
                        + (probe_written[2] != probe_taken[2] ? 2'd3 : 2'd0);
    // Bit 0 of an answer: it is a write's.
    function [1:0] writes_in (input [1:0] first, input [1:0] count, input [3:0] kinds);
        integer i;
        reg [1:0] place;
        begin
            writes_in = 0;
            place = first;
            for (i = 0; i < 3; i = i + 1) begin
                if (i < count) writes_in = writes_in + kinds[place];
                place = place == 2 ? 0 : place + 1;
            end
        end
    endfunction
    wire [3:0] kinds = {probe_answers[102], probe_answers[68], probe_answers[34],
                        probe_answers[0]};
    wire [1:0] held_writes = writes_in(probe_taken[1:0], filled, kinds);
    wire [1:0] held_reads = filled - held_writes;
    wire read_runs = |capture_reads || |coefficient_reads || offset_read || probe_read_acknowledge;

    always @* begin
        assume (running || reset);
        assume (!aw_waits || (awvalid && awaddr == awaddr_before));
        assume (!w_waits || (wvalid && {wdata, wstrb} == w_before));
        assume (!ar_waits || (arvalid && araddr == araddr_before));
        assume (probe_capture_valid == capture_reads[3]);
        assume (!probe_write_acknowledge || write_waits);
        if (running) begin
            assert (!b_waits || (bvalid && bresp == bresp_before));
            assert (!r_waits || (rvalid && {rdata, rresp} == r_before));
            assert (!was_reset || !(bvalid || rvalid));
            assert (!bvalid || (addresses != 0 && data != 0));
            assert (!rvalid || reads != 0);
            assert (!bvalid || bresp == OKAY || bresp == SLVERR);
            assert (!rvalid || rresp == OKAY || rresp == SLVERR);

            // Lemmas. An access is in one of these places: taken and not begun, under way, answered.
            assert (probe_written[1:0] != 3 && probe_taken[1:0] != 3);
            assert (probe_written[2] == probe_taken[2]
                    ? probe_written[1:0] >= probe_taken[1:0]
                    : probe_written[1:0] <= probe_taken[1:0]);
            assert (reads == probe_arvalid + held_reads + read_runs);
            assert (addresses == probe_awvalid + held_writes + write_waits);
            assert (data == probe_wvalid + held_writes + write_waits);
            assert (probe_in_flight == 4'd0 + filled + read_runs + write_waits);
            // One access to a unit at a time.
            assert (4'd0 + capture_reads[0] + capture_reads[1] + capture_reads[2] + capture_reads[3]
                    + coefficient_reads[0] + coefficient_reads[1] + offset_read
                    + (probe_read_acknowledge && probe_external_read_acknowledge)
                    + write_waits == probe_pending);
            assert (!probe_external_read_acknowledge || probe_read_acknowledge);
            assert (probe_read_under_way == coefficient_reads);
            assert (!write_waits || probe_offset_is_written == offset_waits);

            cover (b_waits && bresp == OKAY);
            cover (r_waits && rresp == SLVERR);
            cover (rvalid && rdata == 32'h41524354); // the identification
            cover (write_waits && probe_write_acknowledge);
            cover (capture_reads[0]);
        end
    end

endmodule
