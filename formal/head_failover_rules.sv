// SPDX-License-Identifier: Apache-2.0
//
// No active words of the mean use a head that is left out: its weight is 0, the mean does not wait for it, and it is not
// the carrier. It comes back only after it has seen its index. head_failover decides, and mean_words holds the words.
// Any head may fail at any time, and the processor and the sets may write any words. A model replaces prepared_sets; it
// has the properties that the proof of prepared_sets shows: a swap takes place only while `may_activate` is high, and
// no write is under way then. Source: the entities' headers.

module head_failover_rules #(
    parameter LANES = 1, parameter HEADS = 3, parameter INTERVAL_BITS = 5
) (
    input clock, input reset,
    input write_enable, input [5:0] address, input [31:0] write_data, input clear, input take_snapshot,
    input [2:0] indices_seen, input is_settled,
    input word_write, input [3:0] word_address, input [31:0] word_data, input hold_longer,
    input swap, input set_is_written, input swap_comes
);

    localparam OFFSETS = 28 * HEADS, WEIGHTS = OFFSETS + 18 * HEADS;

    // The model of prepared_sets.
    localparam IDLE = 0, LOADS = 1, ASKS = 2, WAITS = 3;
    reg [1:0] stage = IDLE;
    reg waits = 0, writing = 0, load_then = 0, running = 0;
    wire busy = stage != IDLE;
    wire may_activate, load, changed, parity_beyond, written;
    wire wants = stage == ASKS || (stage == IDLE && swap);
    wire swap_out = wants && may_activate;
    wire refused = wants && !may_activate;
    wire loaded = swap_comes && ((stage == ASKS && may_activate) || stage == WAITS);
    wire [2:0] number, rearm_heads, left_out;
    wire [31:0] read_data, word_read;
    wire [WEIGHTS + HEADS + 1:0] active, idle, next_words;
    wire is_written;
    wire [2:0] active_used = active[WEIGHTS + HEADS - 1:WEIGHTS];
    wire [2:0] idle_used = idle[WEIGHTS + HEADS - 1:WEIGHTS];
    wire [1:0] active_carrier = active[WEIGHTS + HEADS + 1:WEIGHTS + HEADS];
    wire [1:0] idle_carrier = idle[WEIGHTS + HEADS + 1:WEIGHTS + HEADS];
    wire idle_carrier_used = idle_used[idle_carrier];

    head_failover decides (
        .clock(clock), .reset(reset), .read_enable(1'b0), .write_enable(write_enable),
        .address(address), .write_data(write_data), .read_data(read_data),
        .take_snapshot(take_snapshot), .clear(clear), .indices_seen(indices_seen),
        .used(active_used), .idle_used(idle_used), .idle_carrier_used(idle_carrier_used),
        .is_settled(is_settled), .swap_comes(swap_comes), .busy(busy), .loaded(loaded),
        .refused(refused), .may_activate(may_activate), .load(load), .number(number),
        .rearm_heads(rearm_heads), .left_out(left_out), .parity_beyond(parity_beyond),
        .changed(changed)
    );

    mean_words words (
        .clock(clock), .reset(reset), .write_enable(word_write), .write_address(word_address),
        .write_data(word_data), .write_acknowledge(written),
        .hold_writes(swap_out || waits || hold_longer), .read_address(4'd0), .read_data(word_read),
        .swap_comes(swap_comes), .is_written(is_written), .active_words(active),
        .idle_words(idle), .next_words(next_words)
    );

    wire probe_pending, probe_wants_set, probe_swap_refused;
    wire [2:0] probe_wanted_set;
    reg [2:0] left_out_then = 0, rearm_then = 0, forgotten = 7, weighs, of_set;
    reg reset_then = 1, refused_then = 0, clear_then = 0;
    integer head;

    always @* begin
        for (head = 0; head < HEADS; head = head + 1) begin
            weighs[head] = active[OFFSETS + 18 * head +: 18] != 0;
            of_set[head] = number == head + 1;
        end
    end

    // High if the idle words use none of these heads and, if a carrier is needed, their carrier is a used head.
    function words_without(input [2:0] heads, input needs_carrier);
        words_without = (idle_used & heads) == 0 && (idle_carrier_used || !needs_carrier);
    endfunction

    always @(posedge clock) begin
        running <= 1;
        reset_then <= reset;
        load_then <= load && !reset;
        left_out_then <= left_out;
        rearm_then <= rearm_heads;
        refused_then <= refused && !reset;
        writing <= !reset && (word_write || (writing && !written));
        waits <= !reset && (waits || swap_out) && !swap_comes;
        case (stage)
            IDLE: if (load) stage <= LOADS;
            LOADS: if (set_is_written) stage <= ASKS;
            ASKS: stage <= may_activate && !swap_comes ? WAITS : IDLE;
            WAITS: if (swap_comes) stage <= IDLE;
        endcase
        if (reset) stage <= IDLE;
        for (head = 0; head < HEADS; head = head + 1) begin
            if (!left_out[head]) forgotten[head] <= 1;
            else if (indices_seen[head] && !rearm_heads[head]) forgotten[head] <= 0;
        end
    end

    always @* begin
        assume (running || reset);
        // The bus makes one access at a time. The words of a set pass through the same port; all of them are written
        // before the swap of the set is requested.
        assume (!word_write || (!writing && stage != ASKS && stage != WAITS));
        assume (!swap || (!writing && !word_write && !waits));
        assume (!set_is_written || (!writing && !word_write && !waits));
        assume (!swap_comes || waits || swap_out);
        // The decoder of a head forgets its index one clock after rearm_heads requests this.
        assume (!(rearm_then & indices_seen));
        if (running) begin
            weighs_nothing: assert (!(left_out & weighs));
            is_not_used: assert (!(left_out & active_used));
            does_not_carry: assert (!left_out[active_carrier]);
            unused_weighs_nothing: assert (!(~active_used & weighs));
            one_head: assert (left_out == 0 || left_out == 1 || left_out == 2 || left_out == 4);
            after_its_index: assert (reset_then || !(left_out_then & ~left_out & forgotten));
            stays_in_force: assert (!(swap && stage == IDLE && left_out != 0
                                      && (idle_used & left_out)) || (!swap_out && refused));
            is_told: assert (!refused_then || probe_swap_refused);

            // Lemmas for the induction.
            assert (left_out == 0 || active_used[active_carrier]);
            assert (number <= HEADS);
            assert (!probe_wants_set || probe_wanted_set <= HEADS);
            assert (!load || !busy);
            assert (active_carrier < HEADS && idle_carrier < HEADS);
            assert (writing == (probe_pending || written));
            assert (stage != WAITS || waits);
            assert (stage != ASKS || !waits);
            assert (stage != WAITS || words_without(of_set, 1));
            assert (!(waits && stage != WAITS) || words_without(left_out, left_out != 0));
            assert (!((load || busy) && (left_out & ~of_set & forgotten)));
            assert (!(stage == ASKS || stage == WAITS) || (!probe_pending && !written));
            assert (!(stage == ASKS && may_activate) || words_without(of_set, 1));
            assert (!(stage == IDLE && may_activate && !writing && !probe_pending)
                    || words_without(left_out, left_out != 0));

            cover (loaded && number == 2);
            cover (left_out_then != 0 && left_out == 0 && !reset_then);
            cover (refused && stage == IDLE);
            cover (swap_out && left_out != 0 && stage == IDLE);
            cover (left_out == 4 && weighs != 0 && active_carrier == 1);
        end
    end

endmodule
