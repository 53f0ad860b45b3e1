// SPDX-License-Identifier: Apache-2.0
//
// AXI4-Lite rules (AMBA AXI, issue D, A3.1.2, A3.2.1, A3.3.1 and B1.1.1) at the core's port: responses
// stay valid and unchanged until they are accepted, and none is valid after a reset. Each response belongs
// to an earlier accepted transfer, and each transfer gets exactly one response. The master keeps to the same rules.
// Inside the core: requests to a unit are legal and belong to the accepted transfer, a word
// that is read is the one that the unit gave, and neither kind of transfer blocks the other.
//
// The sampler, the compensation, all arithmetic and the signals at the edge of
// the core are left out: the registers may read any value from them. Each register and
// the held half of a wide word may also have any value. Two units answer transfers themselves. The proof assumes that
// the sampler outputs a bank's word 4 clocks after its read (proven: sampler_rules), and that coefficient_memory
// acknowledges each write once, after the write (proven: coefficient_memory_rules).

module arctrue_core_rules #(
    parameter LANES = 1, parameter CAPTURE_DEPTH = 2 // as the netlist
) (
    input clock, input reset,
    input awvalid, input [18:0] awaddr, input wvalid, input [31:0] wdata, input [3:0] wstrb,
    input bready, input arvalid, input [18:0] araddr, input rready
);

    wire awready, wready, bvalid, arready, rvalid;
    wire [1:0] bresp, rresp;
    wire [31:0] rdata;

    // Inputs that are not connected may take any value in any clock.
    arctrue_core core (
        .clock(clock), .reset(reset),
        .s_axil_request_awvalid(awvalid), .s_axil_request_awaddr(awaddr),
        .s_axil_request_wvalid(wvalid), .s_axil_request_wdata(wdata), .s_axil_request_wstrb(wstrb),
        .s_axil_request_bready(bready), .s_axil_request_arvalid(arvalid),
        .s_axil_request_araddr(araddr), .s_axil_request_rready(rready),
        .s_axil_response_awready(awready), .s_axil_response_wready(wready),
        .s_axil_response_bvalid(bvalid), .s_axil_response_bresp(bresp),
        .s_axil_response_arready(arready), .s_axil_response_rvalid(rvalid),
        .s_axil_response_rdata(rdata), .s_axil_response_rresp(rresp)
    );

    localparam OKAY = 0, SLVERR = 2;
    localparam IDLE = 0, BUSY = 1, ANSWER = 2;

    reg running = 0;
    reg was_reset = 1;
    reg aw_waits = 0, w_waits = 0, ar_waits = 0, b_waits = 0, r_waits = 0;
    reg [18:0] awaddr_before, araddr_before;
    reg [35:0] w_before;
    reg [1:0] bresp_before;
    reg [33:0] r_before;
    // Accepted and not yet answered.
    reg [3:0] addresses = 0, data = 0, reads = 0;
    // Transfers of the other kind that were accepted while one waits.
    reg [1:0] before_read = 0, before_write = 0;
    // The last accepted transfer.
    reg [18:0] held_address;
    reg [35:0] held_word;
    reg held_ready;

    wire probe_bank_ready;

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
        if (arvalid && arready) before_read <= 0;
        else if (arvalid && awvalid && awready) before_read <= before_read + 1;
        if (awvalid && awready) before_write <= 0;
        else if (awvalid && wvalid && arvalid && arready) before_write <= before_write + 1;
        if (awvalid && awready) held_address <= awaddr;
        if (arvalid && arready) held_address <= araddr;
        if (wvalid && wready) held_word <= {wdata, wstrb};
        if (arvalid && arready) held_ready <= probe_bank_ready;
        if (reset) begin
            addresses <= 0;
            data <= 0;
            reads <= 0;
            before_read <= 0;
            before_write <= 0;
        end
    end

    // Transfers that another unit answers.
    wire probe_capture_read, probe_capture_valid, probe_write_acknowledge, probe_local_done;
    wire probe_coefficient_read, probe_coefficient_write;
    wire probe_offset_read, probe_offset_write;
    wire [1:0] probe_read_under_way, probe_turns_under_way;
    wire probe_mean_read_then, probe_to_mean, probe_to_heads, probe_to_conditions, probe_to_sets;
    wire probe_to_local, probe_to_turns;
    wire [31:0] probe_capture_data, probe_coefficient_data, probe_offset_data;
    reg [3:0] capture_reads = 0;
    reg [1:0] coefficient_reads = 0;
    reg write_waits = 0, offset_waits = 0;
    reg from_unit = 0; // the answer is a unit's word
    reg [31:0] unit_word;
    wire writes_unit = probe_coefficient_write || probe_offset_write;

    always @(posedge clock) begin
        capture_reads <= {capture_reads, probe_capture_read};
        coefficient_reads <= {coefficient_reads, probe_coefficient_read};
        if (probe_write_acknowledge) write_waits <= 0;
        if (writes_unit) begin
            write_waits <= 1;
            offset_waits <= probe_offset_write;
        end
        if (rvalid && rready) from_unit <= 0;
        if (capture_reads[3] || coefficient_reads[1] || probe_offset_read) begin
            from_unit <= 1;
            unit_word <= capture_reads[3] ? probe_capture_data
                         : probe_offset_read ? probe_offset_data : probe_coefficient_data;
        end
        if (reset) begin
            capture_reads <= 0;
            coefficient_reads <= 0;
            write_waits <= 0;
            from_unit <= 0;
        end
    end

    // For the lemmas: the position of the present transfer.
    wire [1:0] probe_state;
    wire probe_taken, probe_is_write, probe_register_read;
    wire probe_register_request, probe_register_writes;
    // A unit gets its request in the clock after the transfer was accepted.
    reg asks = 0;
    always @(posedge clock) asks <= probe_taken && !reset;
    wire probe_to_registers, probe_to_coefficients, probe_to_offset, probe_to_capture;
    wire probe_refused;
    wire [18:0] probe_address;
    wire [31:0] probe_data;
    wire [3:0] probe_strobes;
    wire [3:0] asked = 4'd0 + capture_reads[0] + capture_reads[1] + capture_reads[2]
                       + capture_reads[3] + coefficient_reads[0] + coefficient_reads[1]
                       + write_waits;
    wire is_out = probe_state == ANSWER || (probe_state == BUSY && !probe_taken);

    always @* begin
        assume (running || reset);
        assume (!aw_waits || (awvalid && awaddr == awaddr_before));
        assume (!w_waits || (wvalid && {wdata, wstrb} == w_before));
        assume (!ar_waits || (arvalid && araddr == araddr_before));
        assume (probe_capture_valid == capture_reads[3]);
        assume (!probe_write_acknowledge || write_waits);
        // The core has no local table (LOCAL_TABLE = false), whose word would answer.
        assume (!probe_local_done);
        if (running) begin
            assert (!b_waits || (bvalid && bresp == bresp_before));
            assert (!r_waits || (rvalid && {rdata, rresp} == r_before));
            assert (!was_reset || !(bvalid || rvalid));
            assert (!bvalid || (addresses != 0 && data != 0));
            assert (!rvalid || reads != 0);
            assert (!bvalid || bresp == OKAY || bresp == SLVERR);
            assert (!rvalid || rresp == OKAY || rresp == SLVERR);
            assert (!rvalid || rresp == OKAY || rdata == 0);

            assert (before_read <= 1 && before_write <= 1);
            assert (!(probe_capture_read || probe_coefficient_read || probe_offset_read)
                    || reads == 1);
            assert (!writes_unit || (addresses == 1 && data == 1));
            assert (!probe_capture_read
                    || (held_address >= 19'h20000 && held_ready
                        && held_address < 19'h20000 + 8 * CAPTURE_DEPTH));
            assert (!(probe_coefficient_read || probe_coefficient_write)
                    || (held_address >= 19'h01000 && held_address < 19'h01000 + 16 * LANES));
            assert (!(probe_offset_read || probe_offset_write) || held_address[18:2] == 17'h0013);
            assert (!writes_unit || held_word[3:0] == 4'b1111);
            assert (!rvalid || !from_unit || (rresp == OKAY && rdata == unit_word));

            // Lemmas. One transfer at a time: accepted, requested, at its unit, answered.
            assert (probe_state != 3);
            assert (!probe_taken || (probe_state == BUSY && !asks));
            assert (!asks || probe_state == BUSY);
            assert (!probe_taken || (probe_is_write ? awvalid && wvalid : arvalid));
            assert (!probe_taken
                    || probe_address == {probe_is_write ? awaddr[18:2] : araddr[18:2], 2'b00});
            assert (!probe_taken || !probe_is_write || {probe_data, probe_strobes} == {wdata, wstrb});
            assert (!is_out || probe_address == {held_address[18:2], 2'b00});
            assert (!is_out || !probe_is_write || {probe_data, probe_strobes} == held_word);
            assert (addresses == (is_out && probe_is_write));
            assert (data == (is_out && probe_is_write));
            assert (reads == (is_out && !probe_is_write));
            assert (!is_out || 3'd0 + probe_to_registers + probe_to_coefficients + probe_to_offset
                               + probe_to_capture + probe_refused == 1);
            assert (asked + probe_register_read == (probe_state == BUSY && !probe_taken && !asks));
            assert (!probe_register_read || (probe_to_registers && !probe_is_write));
            assert (probe_register_request == (asks && probe_to_registers));
            assert (probe_capture_read == (asks && probe_to_capture));
            assert (probe_coefficient_read == (asks && probe_to_coefficients && !probe_is_write));
            assert (probe_coefficient_write == (asks && probe_to_coefficients && probe_is_write));
            assert (probe_offset_read == (asks && probe_to_offset && !probe_is_write));
            assert (probe_offset_write == (asks && probe_to_offset && probe_is_write));
            assert (!asks || !(probe_register_request && probe_register_writes != probe_is_write));
            assert (!asked || !probe_refused);
            assert (!capture_reads || probe_to_capture);
            assert (!coefficient_reads || probe_to_coefficients);
            assert (!write_waits || (offset_waits ? probe_to_offset : probe_to_coefficients));
            assert (!is_out || !probe_to_capture || !probe_is_write);
            assert (!write_waits || probe_is_write);
            assert (!(capture_reads || coefficient_reads) || !probe_is_write);
            assert (probe_read_under_way == coefficient_reads);
            assert (!from_unit || (probe_state == ANSWER && !probe_is_write));
            // The core has no mean, conditions, prepared sets, local table or real orders: nothing reads their words.
            assert (!probe_mean_read_then && probe_turns_under_way == 0);
            assert (!is_out || !(probe_to_mean || probe_to_heads || probe_to_conditions || probe_to_sets
                                 || probe_to_local || probe_to_turns));
            // An overtaken transfer still waits, and is accepted next.
            assert (before_read == 0 || (arvalid && probe_taken != probe_is_write));
            assert (before_write == 0 || (awvalid && wvalid && probe_taken == probe_is_write));

            cover (b_waits && bresp == OKAY);
            cover (b_waits && bresp == SLVERR);
            cover (r_waits && rresp == SLVERR);
            cover (rvalid && rdata == 32'h41524354); // the identification
            cover (write_waits && probe_write_acknowledge);
            cover (rvalid && from_unit && held_address[17]);
            cover (before_read == 1 && arready);
            cover (before_write == 1 && awready);
        end
    end

endmodule
