// SPDX-License-Identifier: Apache-2.0
//
// A swap is atomic over everything that it activates: phase steps, phase offsets, amplitudes and offset of the lanes,
// and points and place of the local table. Each angle uses one bank of all of them, and no word of a bank is written
// while an angle in the pipeline uses this bank. A swap waits until amplitude_sweep and turn_offset_sweep have prepared
// the idle bank; their own rules state what `swept` means. Sweeps and memories are left out: the rules follow the
// number of the bank that each angle reads, and coefficient_memory_rules follow the words. Source: the entity's header.

module compensation_pipeline_rules #(
    parameter LANES = 1, parameter MODULATORS = 1, parameter LOCAL_TABLE = 1,
    parameter REAL_ORDERS = 1
) (
    input clock, input reset, input write_enable, input write_offset, input [7:0] write_address,
    input [31:0] write_data, input write_turn_step, input swap, input swap_allowed,
    input local_read, input local_write, input local_of_place, input [11:0] local_address,
    input [31:0] local_data
);

    localparam OFFSET_DELAY = 25, AMPLITUDE_DELAY = 21, PHASE_OFFSET_DELAY = 2;
    localparam LAST = OFFSET_DELAY;
    localparam FILLED = LAST + 4 * LANES;
    localparam WRITABLE = FILLED + 3;
    localparam TABLE = 17; // clocks from an angle to its value of the table
    localparam FREE = 0, CLEARS = 1;

    wire write_acknowledge, swap_comes, swap_busy, local_done;

    compensation_pipeline pipeline (
        .clock(clock), .reset(reset), .write_enable(write_enable), .write_offset(write_offset),
        .write_address(write_address), .write_data(write_data),
        .write_acknowledge(write_acknowledge), .write_turn_step(write_turn_step), .swap(swap),
        .swap_allowed(swap_allowed), .swap_comes(swap_comes), .swap_busy(swap_busy),
        .local_read(local_read), .local_write(local_write), .local_of_place(local_of_place),
        .local_address(local_address), .local_data(local_data), .local_done(local_done)
    );

    wire probe_active, probe_step_bank, probe_phase_bank, probe_amplitude_bank, probe_idle_bank;
    wire [24:0] probe_idle_constant, probe_active_constant;
    wire [1:LAST] probe_copying;
    wire probe_swap_waits, probe_is_quiet, probe_answers, probe_writing, probe_filling;
    wire probe_write_now, probe_is_written, probe_is_turn_step, probe_swept, probe_turns_swept;
    wire [7:0] probe_fill_address;
    wire [1:2] probe_fill_under_way;
    wire [0:4 * LANES - 1] probe_selected;
    wire probe_pending_word, probe_pending_offset, probe_pending_turn;
    wire probe_take_over;
    wire probe_table_active, probe_asked, probe_stores, probe_copies, probe_table_bank;
    wire probe_to_read, probe_to_write, probe_looked_up;
    wire [1:0] probe_copy;
    wire [4:0] probe_left_clear;

    reg running = 0;
    // The references: for the angle of each earlier clock, the bank of the lanes, the offset, and the bank of the table.
    reg [0:LAST] bank = 0;
    reg [0:TABLE] table_bank = 0;
    reg [24:0] offsets [0:LAST];
    integer i;
    initial for (i = 0; i <= LAST; i = i + 1) offsets[i] = 0;
    reg [7:0] since = WRITABLE + 2; // clocks since the last swap took place
    reg [4:0] table_since = TABLE + 1; // clocks since the last swap of the table
    reg waits = 0, table_waits = 0, table_writes = 0, asked = 0;
    reg [11:0] address_then;
    reg [31:0] data_then;
    reg of_place_then;

    wire starts = write_enable || write_offset || write_turn_step;
    wire one_bank = since > LAST;
    wire one_table = table_since > TABLE;
    wire choice_written = table_waits && local_done && table_writes && of_place_then && address_then[2:0] == 0;
    wire asked_now = asked || choice_written;
    wire table_swaps = swap_comes && asked_now;

    always @(posedge clock) begin
        running <= 1;
        bank <= {bank[0] ^ swap_comes, bank[0:LAST - 1]};
        table_bank <= {table_bank[0] ^ table_swaps, table_bank[0:TABLE - 1]};
        if (swap_comes) offsets[0] <= probe_idle_constant;
        for (i = 1; i <= LAST; i = i + 1) offsets[i] <= offsets[i - 1];
        if (swap_comes) since <= 1;
        else if (since < WRITABLE + 2) since <= since + 1;
        if (table_swaps) table_since <= 1;
        else if (table_since <= TABLE) table_since <= table_since + 1;
        asked <= !reset && asked_now && !swap_comes;
        waits <= !reset && (starts || (waits && !write_acknowledge));
        table_waits <= !reset && (local_read || local_write || (table_waits && !local_done));
        if (local_read || local_write) table_writes <= local_write;
        address_then <= local_address;
        data_then <= local_data;
        of_place_then <= local_of_place;
    end

    // Lemmas: the banks of older angles differ only by the last swap.
    genvar d;
    generate
        for (d = 1; d <= LAST; d = d + 1) begin : ages
            always @* if (running) begin
                assert (bank[d] == bank[d - 1] ^ (since == d));
                assert (probe_copying[d] == (since == d));
                assert (since == d || offsets[d] == offsets[d - 1]);
            end
        end
        for (d = 1; d <= TABLE; d = d + 1) begin : table_ages
            always @* if (running) assert (table_bank[d] == table_bank[d - 1] ^ (table_since == d));
        end
    endgenerate

    always @* begin
        assume (running || reset);
        // The processor makes one access at a time and keeps address and data until its end.
        assume (write_enable + write_offset + write_turn_step <= 1);
        assume (!starts || !waits || write_acknowledge);
        assume (!(local_read && local_write));
        assume (!(local_read || local_write) || !table_waits || local_done);
        assume (!table_waits || local_done || (local_address == address_then && local_data == data_then
                                               && local_of_place == of_place_then));
        if (running) begin
            // Each kind of word comes from the bank of its angle; a memory outputs the word one clock after the choice of
            // the bank.
            steps_of_the_bank: assert (probe_step_bank == bank[0] ^ swap_comes);
            phase_offsets_of_the_bank: assert (probe_phase_bank == bank[PHASE_OFFSET_DELAY - 1]);
            amplitudes_of_the_bank: assert (probe_amplitude_bank == bank[AMPLITUDE_DELAY - 1]);
            offset_of_the_bank: assert (probe_active_constant == offsets[OFFSET_DELAY]);
            table_of_the_bank: assert (probe_table_active == table_bank[0]);
            // The table swaps with the lanes, if its word `choice` was written, and never alone.
            table_if_asked: assert (probe_asked == asked_now);

            // No word of a bank that is in use is written.
            lanes_written_when_idle: assert (probe_selected == 0 && !probe_is_written && !probe_is_turn_step && !probe_write_now
                                             || one_bank && probe_idle_bank != bank[0]);
            turn_steps_taken_over_when_idle: assert (!probe_take_over || since >= LAST);
            table_written_when_idle: assert (!probe_stores && !probe_copies
                                             || one_table && (local_of_place && probe_stores || probe_table_bank != table_bank[0]));
            place_copied_when_idle: assert (!(probe_copy == CLEARS && probe_left_clear == 1) || table_since >= TABLE);

            // A swap takes over a prepared bank and whole writes.
            bank_is_prepared: assert (!swap_comes || (probe_swept && probe_turns_swept && swap_allowed));
            bank_is_filled: assert (!swap_comes || (since > WRITABLE && !probe_filling && probe_fill_under_way == 0));
            writes_are_whole: assert (!swap_comes || !(probe_write_now || probe_writing || probe_is_written || probe_is_turn_step
                                                       || probe_stores));
            swap_holds_the_table: assert (!probe_stores || !(swap || swap_busy));
            swap_was_asked: assert (!swap_comes || swap || probe_swap_waits);

            // Lemmas: the lanes.
            assert (since != 0 && table_since != 0);
            assert (probe_active == bank[0] && probe_idle_bank != bank[0]);
            assert (since > LAST || probe_idle_constant == offsets[0]);
            assert (!probe_is_quiet || since >= WRITABLE);
            assert (!probe_swap_waits || swap_busy);
            assert (probe_filling == (since > LAST && since <= FILLED));
            assert (!probe_filling || probe_fill_address == since - LAST - 1);
            assert (probe_fill_under_way[1] == (since > LAST + 1 && since <= FILLED + 1));
            assert (probe_fill_under_way[2] == (since > LAST + 2 && since <= FILLED + 2));
            assert (probe_writing == (probe_answers || (since > LAST + 3 && since <= FILLED + 3)));
            assert (!(probe_is_written || probe_is_turn_step || probe_selected != 0) || probe_writing);
            assert (!probe_answers || (since > WRITABLE && waits && !write_acknowledge));
            assert (probe_pending_word + probe_pending_offset + probe_pending_turn <= 1);
            assert (!(probe_pending_word || probe_pending_offset || probe_pending_turn) || (waits && !write_acknowledge && !probe_answers));

            // Lemmas: the table.
            assert (probe_copy != CLEARS || (probe_left_clear == TABLE + 1 - table_since && probe_left_clear != 0));
            assert (probe_copy == CLEARS || one_table);
            assert (!probe_asked || probe_copy == FREE);
            assert (!(probe_to_read || probe_to_write || probe_looked_up) || (table_waits && !local_done));
            assert (!probe_to_write || table_writes);
            assert (!(probe_to_read || probe_looked_up) || !table_writes);
            assert (probe_to_read + probe_to_write + probe_looked_up <= 1);
            assert (!table_waits || local_done || probe_to_read || probe_to_write || probe_looked_up);

            cover (swap_comes && probe_asked && bank[0] == 0);
            cover (since == TABLE && table_since == TABLE);
            cover (since == LAST && table_since > TABLE && probe_idle_constant != offsets[LAST]);
            cover (swap_busy && probe_to_write && probe_pending_turn);
        end
    end

endmodule
