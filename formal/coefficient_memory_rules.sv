// SPDX-License-Identifier: Apache-2.0
//
// Every angle meets the coefficients of one bank, that of the last swap before it: all writes that
// were acknowledged by then and no part of another. Swaps, also during a copy, their waits, writes and resets in
// any clock. A write is acknowledged in the time that the header states. Source: the entity's header.

module coefficient_memory_rules #(
    parameter LANES = 1,
    // Clocks from the phase step to the other coefficients.
    parameter PHASE_OFFSET_DELAY = 2, parameter AMPLITUDE_DELAY = 21,
    parameter OFFSET_DELAY = 25 // the largest
) (
    input clock, input reset, input write_enable, input write_offset, input [7:0] write_address,
    input [31:0] write_data, input swap, input swap_allowed
);

    localparam LAST = OFFSET_DELAY;

    wire write_acknowledge, swap_marker, swap_busy;
    wire [48 * LANES - 1:0] phase_steps;
    wire [24 * LANES - 1:0] phase_offsets;
    wire [25 * LANES - 1:0] amplitudes;
    wire [24:0] offset, idle_offset;

    coefficient_memory memory (
        .clock(clock), .reset(reset), .write_enable(write_enable), .write_offset(write_offset),
        .write_address(write_address), .write_data(write_data),
        .write_acknowledge(write_acknowledge), .idle_offset(idle_offset), .swap(swap),
        .swap_allowed(swap_allowed),
        .swap_marker(swap_marker), .swap_busy(swap_busy), .phase_steps(phase_steps),
        .phase_offsets(phase_offsets), .amplitudes(amplitudes), .offset(offset)
    );

    // One bit of a bank, any: of a word by its address, or of the offset, which follows the words.
    (* anyconst *) reg [3:0] place;
    (* anyconst *) reg [4:0] number;
    localparam OFFSET_PLACE = 4 * LANES;
    wire is_offset = place == OFFSET_PLACE;
    wire [1:0] kind = place[1:0];
    wire [5:0] stored = is_offset || kind == 3 ? 25 : kind == 2 ? 24 : kind == 1 ? 16 : 32;
    wire [4:0] age = is_offset ? OFFSET_DELAY : kind == 3 ? AMPLITUDE_DELAY
                     : kind == 2 ? PHASE_OFFSET_DELAY : 0;

    wire [48 * LANES - 1:0] probe_idle_steps;
    wire [24 * LANES - 1:0] probe_idle_offsets;
    wire [25 * LANES - 1:0] probe_idle_amplitudes;
    wire [1:LAST] probe_copying;
    wire probe_swap_waits;
    wire probe_pending_word, probe_pending_offset;
    wire [7:0] probe_address;
    wire [31:0] probe_data;
    wire [0:4 * LANES - 1] probe_selected;
    wire probe_is_quiet;

    // The bit as it comes out and in the idle bank.
    wire [128 * LANES + 31:0] active_words, idle_words;
    assign active_words[128 * LANES +: 32] = offset;
    assign idle_words[128 * LANES +: 32] = idle_offset;
    genvar lane;
    generate
        for (lane = 0; lane < LANES; lane = lane + 1) begin : lanes
            assign active_words[128 * lane +: 64] = phase_steps[48 * lane +: 48];
            assign active_words[128 * lane + 64 +: 32] = phase_offsets[24 * lane +: 24];
            assign active_words[128 * lane + 96 +: 32] = amplitudes[25 * lane +: 25];
            assign idle_words[128 * lane +: 64] = probe_idle_steps[48 * lane +: 48];
            assign idle_words[128 * lane + 64 +: 32] = probe_idle_offsets[24 * lane +: 24];
            assign idle_words[128 * lane + 96 +: 32] = probe_idle_amplitudes[25 * lane +: 25];
        end
    endgenerate
    wire active_bit = active_words[{place, number}];
    wire idle_bit = idle_words[{place, number}];

    reg running = 0;
    // The reference: the bit as it was last acknowledged, and of the bank that an angle of so many
    // clocks ago was entered with.
    reg idle = 0;
    reg [0:LAST] bank = 0;
    reg [1:LAST] swapped = 0;
    reg waits = 0, waits_for_offset;
    reg [7:0] address;
    reg [31:0] data;
    reg [4:0] waited = 0; // clocks since the write and since the last swap

    // A swap waits for the clock before a new angle.
    reg swap_waits = 0;
    wire swap_now = (swap || swap_waits) && swap_allowed;

    wire starts = write_enable || write_offset;
    wire hits = waits_for_offset ? is_offset : !is_offset && address == place;
    wire idle_now = waits && write_acknowledge && hits ? data[number] : idle;

    always @(posedge clock) begin
        running <= 1;
        idle <= idle_now;
        bank <= {swap_now ? idle_now : bank[0], bank[0:LAST - 1]};
        swap_waits <= (swap || swap_waits) && !swap_allowed;
        swapped <= {swap_now, swapped[1:LAST - 1]};
        if (write_acknowledge) waits <= 0;
        if (starts) begin
            waits <= 1;
            waits_for_offset <= write_offset;
            address <= write_address;
            data <= write_data;
        end
        if (swap || swap_waits || starts) waited <= 0;
        else if (!(&waited)) waited <= waited + 1;
        if (reset) waits <= 0;
    end

    // Lemmas: an unfinished swap brings what the idle bank still holds; other banks are alike.
    genvar d;
    generate
        for (d = 1; d <= LAST; d = d + 1) begin : ages
            always @* if (running) begin
                assert (swapped[d] ? bank[d - 1] == idle_now : bank[d] == bank[d - 1]);
                assert (!swapped[d] || waited < d);
            end
        end
    endgenerate

    // One bit says which word waits; none does for the offset.
    genvar word;
    generate
        for (word = 0; word < 4 * LANES; word = word + 1) begin : words
            always @* if (running) begin
                assert (!(probe_pending_word || probe_pending_offset)
                        || probe_selected[word] == (probe_pending_word && probe_address == word));
            end
        end
    endgenerate

    always @* begin
        assume (running || reset);
        assume (!(write_enable && write_offset));
        assume (!starts || !waits || write_acknowledge);
        assume (place <= OFFSET_PLACE && number < stored);
        if (running) begin
            one_bank_an_angle: assert (active_bit == bank[age]);
            assert (idle_bit == idle_now);
            assert (swap_marker == swapped[1]);
            assert (swap_busy == (swap_waits || |swapped));
            assert (!write_acknowledge || waits);
            acknowledged_in_time: assert (!waits || write_acknowledge || waited <= LAST + 1);

            // Lemmas.
            assert (probe_swap_waits == swap_waits);
            assert (probe_copying == swapped);
            assert (probe_is_quiet == ~|swapped);
            assert (!(probe_pending_word && probe_pending_offset));
            assert ((probe_pending_word || probe_pending_offset) == (waits && !write_acknowledge));
            assert (!waits || write_acknowledge || probe_pending_offset == waits_for_offset);
            assert (!waits || write_acknowledge || (probe_address == address && probe_data == data));

            cover (swapped[OFFSET_DELAY] && swapped[PHASE_OFFSET_DELAY] && waits);
            cover (phase_steps[47:32] == 5 && phase_offsets[23:0] == 6);
            cover (write_acknowledge && waits_for_offset && swap);
        end
    end

endmodule
