// SPDX-License-Identifier: Apache-2.0
//
// Every angle gets the coefficients of one bank, which the last swap before the angle made active: this bank contains
// all writes that were acknowledged before this swap, and no word of the other bank. Swaps, writes and resets come in
// any clock, also while a swap waits or the idle bank is filled. Acknowledges, swaps and reads follow the rules of the
// entity's header. The rules follow one arbitrary bit of the coefficients.

module coefficient_memory_rules #(
    parameter LANES = 2,
    parameter FOLD = 1, // lanes that share a pipeline
    // Clocks from the phase step to the other coefficients.
    parameter PHASE_OFFSET_DELAY = 2, parameter AMPLITUDE_DELAY = 21,
    parameter OFFSET_DELAY = 25 // the largest
) (
    input clock, input reset, input write_enable, input write_offset, input [7:0] write_address,
    input [31:0] write_data, input swap, input swap_allowed
);

    localparam BUILT = LANES / FOLD; // lanes whose coefficients come out in one clock
    localparam LAST = OFFSET_DELAY;
    // Clocks after a swap until: the last word of the idle bank is requested; a word can be written; a
    // further swap can take place; a write that waited is acknowledged.
    localparam FILLED = LAST + 4 * LANES;
    localparam WRITABLE = FILLED + 3;
    localparam SWAPPABLE = FILLED + 4;
    localparam ACKNOWLEDGED = FILLED + 5;

    wire write_acknowledge, swap_marker, swap_busy;
    wire [48 * BUILT - 1:0] phase_steps;
    wire [24 * BUILT - 1:0] phase_offsets;
    wire [25 * BUILT - 1:0] amplitudes;
    wire [24:0] offset, idle_offset;
    wire [31:0] read_data;

    // The bit that the rules follow: in the word at an address, or in the offset, which has the next address.
    (* anyconst *) reg [3:0] place;
    (* anyconst *) reg [31:0] one; // the only 1 is in the place of the bit
    localparam OFFSET_PLACE = 4 * LANES;
    wire is_offset = place == OFFSET_PLACE;
    wire [1:0] kind = place[1:0], lane = place[3:2];
    wire [1:0] block = lane / BUILT, column = lane % BUILT;
    wire [5:0] stored = is_offset || kind == 3 ? 25 : kind == 2 ? 24 : kind == 1 ? 16 : 32;
    wire [4:0] age = is_offset ? OFFSET_DELAY : kind == 3 ? AMPLITUDE_DELAY
                     : kind == 2 ? PHASE_OFFSET_DELAY : 0;

    // The slots of fold_sequence.
    reg [2:0] slot = 0;
    wire [2:0] slot_met = (slot + 8'd64 - age) % FOLD;

    // The address of a read affects only `read_data`, so it suffices to read the word of that bit.
    coefficient_memory memory (
        .clock(clock), .reset(reset), .write_enable(write_enable), .write_offset(write_offset),
        .write_address(write_address), .write_data(write_data),
        .write_acknowledge(write_acknowledge), .read_address({4'b0, place}), .read_data(read_data),
        .idle_offset(idle_offset), .swap(swap), .swap_allowed(swap_allowed),
        .swap_marker(swap_marker), .swap_busy(swap_busy), .slot(slot), .phase_steps(phase_steps),
        .phase_offsets(phase_offsets), .amplitudes(amplitudes), .offset(offset)
    );

    // Both banks: 128 bits per lane, without the highest 7 of the last lane, which are not used.
    wire [128 * LANES - 8:0] probe_bank_0, probe_bank_1;
    wire probe_active, probe_phase_bank, probe_amplitude_bank;
    wire [2:0] probe_phase_slot, probe_amplitude_slot;
    wire [1:LAST] probe_copying;
    wire probe_swap_waits, probe_takes_place;
    wire probe_pending_word, probe_pending_offset;
    wire [7:0] probe_address;
    wire [31:0] probe_data;
    wire probe_is_quiet, probe_answers, probe_writing, probe_filling;
    wire [7:0] probe_fill_address, probe_fill_address_1, probe_fill_place;
    wire [1:2] probe_fill_under_way;
    wire [31:0] probe_fill_stored, probe_fill_word, probe_read_stored;
    wire [0:4 * BUILT - 1] probe_selected;
    wire [2:0] probe_selected_slot;
    wire [31:0] probe_written;

    // Loops select the bit at the outputs and in both banks, because a solver needs longer for an indexed part select.
    wire [128 * BUILT - 1:0] active_words;
    genvar part;
    generate
        for (part = 0; part < BUILT; part = part + 1) begin : columns
            assign active_words[128 * part +: 64] = phase_steps[48 * part +: 48];
            assign active_words[128 * part + 64 +: 32] = phase_offsets[24 * part +: 24];
            assign active_words[128 * part + 96 +: 32] = amplitudes[25 * part +: 25];
        end
    endgenerate
    wire [128 * LANES - 1:0] words_0 = probe_bank_0, words_1 = probe_bank_1;
    reg [31:0] active_word, word_0, word_1;
    integer i;
    always @* begin
        active_word = offset;
        word_0 = 0;
        word_1 = 0;
        for (i = 0; i < 4 * LANES; i = i + 1) begin
            if (place == i) begin
                active_word = active_words[32 * (i % (4 * BUILT)) +: 32];
                word_0 = words_0[32 * i +: 32];
                word_1 = words_1[32 * i +: 32];
            end
        end
    end
    wire active_bit = |(active_word & one);
    wire bit_0 = |(word_0 & one);
    wire bit_1 = |(word_1 & one);
    wire active_stored = probe_active ? bit_1 : bit_0;
    wire idle_stored = probe_active ? bit_0 : bit_1;

    reg running = 0;
    // The reference: `idle` is the bit after the last acknowledged write; `bank` is the bit in the bank that was active
    // when the angle of each earlier clock entered.
    localparam OLDEST = LAST + FOLD - 1;
    reg idle = 0;
    reg [0:OLDEST] bank = 0;
    reg [7:0] since = ACKNOWLEDGED; // clocks since the last swap took place
    reg waits = 0, waits_for_offset;
    reg [7:0] address;
    reg [31:0] data;
    reg [1:0] waited = 0; // clocks since the write was started
    reg [0:1] read_back = 0; // as the bit was read 1 and 2 clocks ago
    reg finishes = 0, swap_before = 0;

    // A swap waits until the idle bank is filled, for the clock before a new angle, and for a write
    // that is acknowledged in the next clock.
    reg swap_waits = 0;
    wire swap_now = (swap || swap_waits) && swap_allowed && since >= SWAPPABLE && !probe_answers;

    wire starts = write_enable || write_offset;
    wire data_bit = |(data & one);
    wire hits = waits_for_offset ? is_offset : !is_offset && address == place;
    wire idle_now = waits && write_acknowledge && hits ? data_bit : idle;
    // A write is stored a clock before its acknowledge. A reset in that clock cancels only the
    // acknowledge; any other reset cancels the write.
    wire finishing = probe_answers && hits;
    wire idle_next = finishing ? data_bit : idle_now;

    always @(posedge clock) begin
        running <= 1;
        slot <= (slot + 1) % FOLD;
        idle <= reset ? idle_next : idle_now;
        bank <= {swap_now ? idle_now : bank[0], bank[0:OLDEST - 1]};
        swap_waits <= !reset && (swap || swap_waits) && !swap_now;
        swap_before <= swap_now;
        finishes <= probe_answers && !reset;
        read_back <= {idle_next, read_back[0]};
        if (swap_now) since <= 1;
        else if (since < ACKNOWLEDGED) since <= since + 1;
        if (write_acknowledge) waits <= 0;
        if (starts) begin
            waits <= 1;
            waits_for_offset <= write_offset;
            address <= write_address;
            data <= write_data;
        end
        if (starts) waited <= 1;
        else if (waited < 3) waited <= waited + 1;
        if (reset) waits <= 0;
    end

    // Lemmas: after a swap the active bit equals the reference of the idle bank; in clocks without a swap the active
    // bit does not change.
    genvar d;
    generate
        for (d = 1; d <= OLDEST; d = d + 1) begin : ages
            always @* if (running)
                assert (since == d ? bank[d - 1] == idle_now : bank[d] == bank[d - 1]);
        end
        for (d = 1; d <= LAST; d = d + 1) begin : copies
            always @* if (running) assert (probe_copying[d] == (since == d));
        end
    endgenerate

    // The word that is being written into the idle bank.
    wire enters = probe_selected[4 * column + kind] && probe_selected_slot == block;

    always @* begin
        assume (running || reset);
        assume (!(write_enable && write_offset));
        assume (!starts || !waits || write_acknowledge);
        assume (!swap_allowed || slot == FOLD - 1);
        assume (place <= OFFSET_PLACE && one != 0 && (one & (one - 1)) == 0 && one >> stored == 0);
        if (running) begin
            one_bank_an_angle: assert (!is_offset && slot_met != block
                                       || active_bit == bank[is_offset ? age : age + block]);
            read_back_is_idle: assert (is_offset ? (|(idle_offset & one)) == idle_next
                                       : (|(read_data & one)) == read_back[1]);
            assert (swap_marker == swap_before);
            assert (!swap_marker || slot == 0);
            assert (swap_busy == (swap_waits || since < WRITABLE));
            assert (write_acknowledge == finishes);
            assert (!write_acknowledge || waits);
            acknowledged_in_time: assert (!waits || write_acknowledge || swap_waits || waited < 3
                                          || since < ACKNOWLEDGED);
            swap_takes_place: assert (!swap_waits || !swap_allowed || since < SWAPPABLE || swap_now);

            // Lemmas: the swap and the write that wait.
            assert (probe_swap_waits == swap_waits);
            assert (probe_takes_place == swap_now);
            assert (probe_is_quiet == (since >= WRITABLE));
            assert (!(probe_pending_word && probe_pending_offset));
            assert (!(probe_pending_word || probe_pending_offset) || !probe_answers);
            assert ((probe_pending_word || probe_pending_offset || probe_answers)
                    == (waits && !write_acknowledge));
            assert (!(probe_pending_word || probe_pending_offset)
                    || probe_pending_offset == waits_for_offset);
            assert (!waits || write_acknowledge || (probe_address == address && probe_data == data));
            assert (!(probe_pending_word || probe_pending_offset) || swap_waits || waited == 1
                    || since <= WRITABLE);
            assert (!probe_answers || (since > WRITABLE && !swap_waits));
            assert (!probe_answers || waited == 2 || since <= SWAPPABLE);

            // Lemmas: the filling of the idle bank.
            assert (probe_filling == (since > LAST && since <= FILLED));
            assert (probe_fill_under_way[1] == (since > LAST + 1 && since <= FILLED + 1));
            assert (probe_fill_under_way[2] == (since > LAST + 2 && since <= FILLED + 2));
            assert (probe_writing == (probe_answers || (since > LAST + 3 && since <= FILLED + 3)));
            assert (!probe_filling || probe_fill_address == since - LAST - 1);
            assert (!probe_fill_under_way[1] || probe_fill_address_1 == since - LAST - 2);
            assert (!probe_fill_under_way[2] || probe_fill_place == since - LAST - 3);
            assert (probe_selected_slot < FOLD);
            if (!is_offset) begin
                assert ((|(probe_read_stored & one)) == read_back[0]);
                assert (!probe_fill_under_way[1] || probe_fill_address_1 != place
                        || (|(probe_fill_stored & one)) == idle_now);
                assert (!probe_fill_under_way[2] || probe_fill_place != place
                        || (|(probe_fill_word & one)) == idle_now);
                assert (enters == (finishing || since == LAST + 4 + place));
                assert (!enters || (|(probe_written & one)) == (finishing ? data_bit : idle_now));
                // Both banks.
                assert (active_stored == bank[0]);
                if (since <= LAST) assert (idle_stored == bank[since]);
                if (since > LAST + 4 + place) assert (idle_stored == idle_now);
            end

            // Lemmas: the bank and the slot that are read for the next clock.
            assert (probe_phase_bank == (probe_active ^ (since < PHASE_OFFSET_DELAY)));
            assert (probe_amplitude_bank == (probe_active ^ (since < AMPLITUDE_DELAY)));
            assert (probe_phase_slot == (slot + 8'd65 - PHASE_OFFSET_DELAY) % FOLD);
            assert (probe_amplitude_slot == (slot + 8'd65 - AMPLITUDE_DELAY) % FOLD);
            assert (since > OLDEST || slot == (since + 8'd63) % FOLD);

            cover (probe_copying[OFFSET_DELAY] && waits);
            cover (phase_steps[47:32] == 5 && phase_offsets[23:0] == 6);
            cover (write_acknowledge && waits_for_offset && swap);
            cover (swap && swap_allowed && probe_answers);
            cover (swap_waits && swap_now && waits && waited == 3);
        end
    end

endmodule
