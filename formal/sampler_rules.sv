// SPDX-License-Identifier: Apache-2.0
//
// The sampler never writes a bank that belongs to the processor, and a read reaches no other bank.
// The processor keeps the bank, with its header, until the release. A trigger may come in any clock; the
// memory itself is not part of the proof: the rules observe its write and read ports. Source: the entity's header,
// "Ownership".

module sampler_rules #(
    parameter DEPTH = 2 // samples per bank
) (
    input clock, input reset, input enable, input release_bank, input read_enable,
    input [14:0] read_address
);

    wire capture_ready, capture_overrun, bank_ready, ready_bank, read_valid;
    wire [63:0] header_start_time;
    wire [31:0] header_sequence;
    wire [15:0] header_sample_count, overrun_count, fill_count;
    wire [9:0] header_flags;

    // Inputs that are not connected may take any value in any clock.
    sampler capture (
        .clock(clock), .reset(reset), .enable(enable), .release_bank(release_bank),
        .capture_ready(capture_ready), .capture_overrun(capture_overrun),
        .bank_ready(bank_ready), .ready_bank(ready_bank), .header_start_time(header_start_time),
        .header_sequence(header_sequence), .header_sample_count(header_sample_count),
        .header_flags(header_flags), .overrun_count(overrun_count), .fill_count(fill_count),
        .read_enable(read_enable), .read_address(read_address), .read_valid(read_valid)
    );

    wire probe_write_enable, probe_handing_over, probe_filling_bank, probe_first, probe_is_last;
    wire [14:0] probe_write_address, probe_memory_read_address, probe_samples;
    wire [2:0] probe_readable;

    wire written_bank = probe_write_address >= DEPTH;
    wire [122:0] header = {header_start_time, header_sequence, header_sample_count, header_flags,
                           ready_bank};
    reg running = 0;
    reg was_reset = 1, was_ready = 0, was_released = 0, banks_ready = 0;
    reg bank_then = 0;
    reg [122:0] header_before;
    reg [3:0] reads = 0;
    reg [1:0] handed_over = 0;

    always @(posedge clock) begin
        running <= 1;
        was_reset <= reset;
        was_ready <= bank_ready && !reset;
        was_released <= release_bank;
        header_before <= header;
        bank_then <= ready_bank;
        reads <= reset ? 0 : {reads, read_enable};
        if (capture_ready && !(&handed_over)) handed_over <= handed_over + 1;
    end

    always @* begin
        assume (running || reset);
        if (running) begin
            never_written: assert (!(probe_write_enable && bank_ready
                                     && written_bank == ready_bank));
            stays_inside: assert (!probe_write_enable || probe_write_address < 2 * DEPTH);
            reads_its_own: assert (was_reset || !probe_readable[0]
                                   || (probe_memory_read_address >= DEPTH) == bank_then);
            reads_inside: assert (was_reset || !probe_readable[0] || probe_memory_read_address < 2 * DEPTH);
            kept_to_release: assert (!was_ready || was_released || bank_ready);
            header_stands: assert (!(was_ready && bank_ready && !capture_ready)
                                   || header == header_before);
            told_once: assert (!capture_ready || bank_ready);
            answers_reads: assert (read_valid == reads[3]);

            // Lemmas: the progress of the filling.
            assert (!probe_write_enable
                    || written_bank == (probe_handing_over ? ready_bank : probe_filling_bank));
            assert (!(bank_ready || probe_handing_over) || ready_bank != probe_filling_bank);
            assert (!(bank_ready && probe_handing_over && !release_bank) || was_released);
            assert (probe_samples < DEPTH);
            assert (probe_is_last == (probe_samples == DEPTH - 1));
            assert (!probe_first || probe_samples == 0);
            assert (!(bank_ready || probe_handing_over) || header_sample_count <= DEPTH);

            cover (bank_ready && probe_write_enable && ready_bank);
            cover (capture_overrun);
            cover (handed_over == 3 && !bank_ready);
            cover (bank_ready && probe_readable[0] && !ready_bank);
        end
    end

endmodule
