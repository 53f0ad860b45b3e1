// SPDX-License-Identifier: Apache-2.0
//
// The phase offset that an angle reads was computed for the angle's own turn, from the present words of the bank, at
// every wrap and in every clock between two wraps. So the phase is a function of turn and angle, and at a wrap it
// changes only by the step of the angle; turn_counter_rules prove that turn and angle together follow the angle.
// Between two wraps in the same direction the angle moves at least half a turn of the smallest permitted length, at one
// count per clock; a wrap in the other direction may follow at once. The rules follow one arbitrary lane; the
// words that the entity reads from its memories are those of this lane. The benches compare the arithmetic behind the
// multiplier with the model. scripts/formal_proofs states the numbers of bits. Source: the entity's header.

module turn_offset_sweep_rules #(
    parameter LANES = 2
) (
    input clock, input up, input down, input idle_bank, input write_low, input write_high,
    input write_offset, input [5:0] write_lane, input [31:0] write_word, input take_over
);

    localparam STEP = 36, PHASE = 12, TURN = 3;
    localparam SWEEP = 18 * LANES;
    localparam HALF_TURN = 36 * LANES + 24; // REAL_ORDER_COUNTS_A_LANE and REAL_ORDER_COUNTS_FURTHER, halved
    localparam LANE_BITS = LANES - 1;
    localparam ITEM = 5 + LANE_BITS;
    // Clocks until the memory holds the offset of an item: from the item, and from the first read of a word for it.
    localparam WRITTEN = 6, READ = 9;
    localparam OLD = 2 * SWEEP + 8; // clocks after a write until all offsets are computed anew
    localparam OLDEST = OLD + 4;

    (* anyconst *) wire lane_of_rules;
    wire copies, swept, bank;
    wire [0:LANES - 1] selected;
    wire [1:0] of_turn;
    wire [PHASE - 1:0] prepared;
    // The turn of the angle of one clock ago, and of the clock before it.
    reg [TURN - 1:0] turn_1 = 0, turn_2 = 0;

    turn_offset_sweep sweep (
        .clock(clock), .turn(turn_2), .idle_bank(idle_bank), .write_low(write_low),
        .write_high(write_high), .write_offset(write_offset), .write_lane(write_lane),
        .write_word(write_word), .take_over(take_over), .copies(copies), .swept(swept),
        .selected(selected), .bank(bank), .of_turn(of_turn), .prepared(prepared)
    );

    wire [ITEM - 1:0] probe_now;
    wire [31:0] probe_low_1, probe_to_low;
    wire [STEP - 33:0] probe_high_1, probe_to_high;
    wire [PHASE - 1:0] probe_offset_1;
    wire [5:0] probe_to_lane;
    wire probe_copied, probe_copying;
    wire [$clog2(SWEEP + 5) - 1:0] probe_copy_left;
    wire [$clog2(2 * SWEEP + 11) - 1:0] probe_sweep_left;
    wire [TURN - 1:0] probe_middle, probe_above, probe_below, probe_turn_2;
    wire [1:0] probe_low_turn_3, probe_low_turn_4;
    wire [4 * ITEM - 1:0] probe_items;
    wire signed [17:0] probe_part_2;
    wire [PHASE - 1:0] probe_offset_2;

    function [1:0] which_of(input [ITEM - 1:0] item);
        which_of = item[4 + LANE_BITS:3 + LANE_BITS];
    endfunction

    function bank_of(input [ITEM - 1:0] item);
        bank_of = item[2 + LANE_BITS];
    endfunction

    function lane_of(input [ITEM - 1:0] item);
        lane_of = LANES == 1 ? 1'b0 : item[2];
    endfunction

    function [7:0] place_of(input [ITEM - 1:0] item);
        place_of = ((which_of(item) * 2 + bank_of(item)) * LANES + lane_of(item)) * 3 + item[1:0];
    endfunction

    function [7:0] before(input [7:0] place, input [7:0] clocks);
        before = place >= clocks ? place - clocks : place + SWEEP - clocks;
    endfunction

    wire [1:0] part = probe_now[1:0], which = which_of(probe_now);
    wire bank_now = bank_of(probe_now);
    wire lane_now = lane_of(probe_now);
    wire is_lane = lane_now == lane_of_rules;
    wire [7:0] place = place_of(probe_now);
    // The place of the item whose offset the memory holds from this clock on.
    wire [7:0] stored_place = before(place, WRITTEN);

    reg running = 0;
    // Least number of clocks until the next wrap upwards, and until the next wrap downwards.
    reg [7:0] up_after = 0, down_after = 0;
    // The words of the lane in both banks, whether they have never been written, and clocks since the last write.
    reg [STEP - 1:0] step [0:1];
    reg [PHASE - 1:0] offset [0:1];
    reg [1:0] untouched = 3;
    reg [7:0] age [0:1];
    initial begin
        step[0] = 0; step[1] = 0; offset[0] = 0; offset[1] = 0; age[0] = OLDEST; age[1] = OLDEST;
    end
    // Words that the entity reads.
    reg [STEP - 1:0] read_step = 0;
    reg [PHASE - 1:0] read_offset = 0;
    reg read_is_lane = 0;
    // The turn of the item in each stage, and for each bank and place modulo 4 the turn of the offset in the memory, and
    // whether the offset belongs to the words.
    reg [ITEM - 1:0] now_1 = 0, now_2 = 0, now_3 = 0, now_4 = 0, now_5 = 0;
    reg [1:5] follows_now = 0; // the items in the stages belong to one sweep
    reg [TURN - 1:0] turn_of_2 = 0, turn_of_3 = 0, turn_of_4 = 0, turn_of_5 = 0;
    reg [TURN - 1:0] turn_stored [0:7];
    reg [7:0] is_of_words = 0;
    integer i;
    initial for (i = 0; i < 8; i = i + 1) turn_stored[i] = 0;
    // The turn in the middle of the sweep whose offsets are being stored, and of the sweep before it.
    reg [TURN - 1:0] middle = 0, middle_before = 0;
    reg idle_then = 0, may_swap_then = 0, got = 0, copies_then = 0;

    wire [1:0] writes_step_low = (write_low || probe_copied) && probe_to_lane == lane_of_rules ? 2'd1 << idle_bank : 2'd0;
    wire [1:0] writes_step_high = (write_high || probe_copied) && probe_to_lane == lane_of_rules ? 2'd1 << idle_bank : 2'd0;
    wire [1:0] writes_offset = write_offset && write_lane == lane_of_rules ? 2'd1 << idle_bank : 2'd0;
    wire [1:0] writes = writes_step_low | writes_step_high | writes_offset;
    wire stores = selected[lane_of_rules];

    always @(posedge clock) begin
        running <= 1;
        turn_1 <= turn_1 + up - down;
        turn_2 <= turn_1;
        up_after <= up ? HALF_TURN : down || up_after == 0 ? 0 : up_after - 1;
        down_after <= down ? HALF_TURN : up || down_after == 0 ? 0 : down_after - 1;
        for (i = 0; i < 2; i = i + 1) begin
            if (writes_step_low[i]) step[i][31:0] <= probe_to_low;
            if (writes_step_high[i]) step[i][STEP - 1:32] <= probe_to_high;
            if (writes_offset[i]) offset[i] <= write_word[PHASE - 1:0];
            if (writes[i]) begin
                age[i] <= 1;
                untouched[i] <= 0;
            end else if (age[i] < OLDEST) age[i] <= age[i] + 1;
        end
        read_step <= step[bank_now];
        read_offset <= offset[bank_now];
        read_is_lane <= is_lane;
        {now_1, now_2, now_3, now_4, now_5} <= {probe_now, now_1, now_2, now_3, now_4};
        follows_now <= {1'b1, follows_now[1:4]};
        turn_of_2 <= which_of(now_1) == 0 ? probe_middle : which_of(now_1) == 1 ? probe_above : probe_below;
        turn_of_3 <= turn_of_2;
        turn_of_4 <= turn_of_3;
        turn_of_5 <= turn_of_4;
        if (stores) turn_stored[{bank, turn_of_5[1:0]}] <= turn_of_5;
        for (i = 0; i < 8; i = i + 1) begin
            if (stores && {bank, turn_of_5[1:0]} == i) is_of_words[i] <= age[i / 4] >= READ - 1;
            if (writes[i / 4]) is_of_words[i] <= 0;
        end
        if (stored_place == SWEEP - 1) begin
            middle <= probe_middle;
            middle_before <= middle;
        end
        idle_then <= idle_bank;
        may_swap_then <= swept && !copies && !take_over && !write_low && !write_high && !write_offset;
        copies_then <= copies;
        if (take_over) got <= 0;
        else if (probe_copied && probe_to_lane == lane_of_rules) got <= 1;
    end

    // The turn of an item `clocks` clocks behind the newest.
    function [TURN - 1:0] turn_of(input [ITEM - 1:0] item, input [7:0] clocks);
        turn_of = (place >= clocks ? probe_middle : middle) + (which_of(item) == 1) - (which_of(item) == 2);
    endfunction

    function [16:0] part_of(input [STEP - 1:0] whole, input [1:0] number);
        part_of = number == 0 ? whole[16:0] : number == 1 ? whole[33:17] : whole[STEP - 1:34];
    endfunction

    // High if the item in a stage is of the lane, and its words have not changed since their first read.
    function is_clean(input [ITEM - 1:0] item, input [7:0] stage);
        is_clean = lane_of(item) == lane_of_rules && age[bank_of(item)] > stage + item[1:0];
    endfunction

    // High if the memory has the offset of a turn, computed from the present words. Words that have never been written
    // are 0, and so are all their offsets.
    function has(input of_bank, input [TURN - 1:0] turn);
        has = untouched[of_bank] || (is_of_words[{of_bank, turn[1:0]}] && turn_stored[{of_bank, turn[1:0]}] == turn);
    endfunction

    function is_near(input [TURN - 1:0] turn, input [TURN - 1:0] other);
        is_near = turn == other || turn == other + 3'd1 || turn == other - 3'd1;
    endfunction

    // The turn differs by at most 1 from its value `clocks` clocks ago. If it differs, the next wrap in that direction
    // needs about another half turn.
    function follows(input [TURN - 1:0] old, input [7:0] clocks);
        follows = is_near(turn_1, old)
                  && (turn_1 != old + 3'd1 || up_after + clocks + 1 >= HALF_TURN)
                  && (turn_1 != old - 3'd1 || down_after + clocks + 1 >= HALF_TURN);
    endfunction

    genvar b, w;
    generate
        for (b = 0; b < 2; b = b + 1) begin : banks
            for (w = 0; w < 3; w = w + 1) begin : turns
                // Lemmas: the offsets of this sweep and of the sweep before it are stored.
                wire [7:0] item = ((w * 2 + b) * LANES + lane_of_rules) * 3 + 2;
                wire [TURN - 1:0] its_turn = w == 0 ? middle : w == 1 ? middle + 3'd1 : middle - 3'd1;
                wire [TURN - 1:0] its_turn_before = w == 0 ? middle_before : w == 1 ? middle_before + 3'd1 : middle_before - 3'd1;
                always @* if (running) begin
                    assert (stored_place < item || age[b] + item < stored_place + READ || has(b, its_turn));
                    assert (age[b] + item < stored_place + SWEEP + READ || has(b, its_turn_before));
                end
            end
        end
    endgenerate

    genvar stage;
    generate
        for (stage = 1; stage <= 5; stage = stage + 1) begin : young
            always @* if (running)
                assert (follows_now[stage] || (untouched[0] || age[0] <= stage + 1) && (untouched[1] || age[1] <= stage + 1));
        end
    endgenerate

    // The words that are copied into the idle bank are those of the active bank, in this place of the sweep.
    wire [7:0] copied_place = ((!idle_bank) * LANES + lane_of_rules) * 3 + 2;
    wire [7:0] clocks_to_copy = copied_place >= place ? copied_place - place : copied_place + SWEEP - place;

    always @* begin
        assume (lane_of_rules < LANES);
        assume (!(up && down) && (!up || up_after == 0) && (!down || down_after == 0));
        assume (!read_is_lane || ({probe_high_1, probe_low_1} == read_step && probe_offset_1 == read_offset));
        // coefficient_memory swaps while `swept` is high, starts a copy only then, and writes no turn step during a copy.
        assume (idle_bank == idle_then || may_swap_then || !running);
        assume (!take_over || (!copies && !write_low && !write_high));
        assume (!copies || !(write_low || write_high));
        assume (!write_low || !write_high);
        if (running) begin
            own_turn_at_every_angle: assert ((age[0] < OLD || has(0, turn_1)) && (age[1] < OLD || has(1, turn_1)));
            place_of_the_turn: assert (!stores || of_turn == turn_of_5[1:0]);
            swept_is_whole: assert (!swept || (age[idle_bank] >= OLD));
            active_stays_whole: assert (age[!idle_bank] >= OLD);
            copied_whole: assert (!(copies_then && !copies) || step[0] == step[1]);

            // Lemmas: the sweep.
            assert (part < 3 && which < 3 && place < SWEEP && lane_now < LANES);
            assert (probe_above == probe_middle + 3'd1 && probe_below == probe_middle - 3'd1
                    || probe_middle == 0 && probe_above == 0 && probe_below == 0 && place == 0 && follows_now == 0);
            assert (place != 0 && place < WRITTEN || middle == probe_middle);
            assert ((follows_now[2] <= follows_now[1]) && (follows_now[3] <= follows_now[2]) && (follows_now[4] <= follows_now[3])
                    && (follows_now[5] <= follows_now[4]));
            assert ((!untouched[0] || step[0] == 0 && offset[0] == 0) && (!untouched[1] || step[1] == 0 && offset[1] == 0));
            assert (probe_items == {now_1, now_2, now_3, now_4});
            assert (!follows_now[1] || place_of(now_1) == before(place, 1));
            assert (!follows_now[2] || place_of(now_2) == before(place, 2) && turn_of_2 == turn_of(now_2, 2));
            assert (!follows_now[3] || place_of(now_3) == before(place, 3) && turn_of_3 == turn_of(now_3, 3));
            assert (!follows_now[4] || place_of(now_4) == before(place, 4) && turn_of_4 == turn_of(now_4, 4));
            assert (!follows_now[5] || place_of(now_5) == before(place, 5) && turn_of_5 == turn_of(now_5, 5));
            assert (now_1[1:0] < 3 && now_2[1:0] < 3 && now_3[1:0] < 3 && now_4[1:0] < 3 && now_5[1:0] < 3);
            assert (probe_turn_2 == turn_of_2 && probe_low_turn_3 == turn_of_3[1:0] && probe_low_turn_4 == turn_of_4[1:0]);
            assert (bank == bank_of(now_5));
            assert (stores == (now_5[1:0] == 2 && lane_of(now_5) == lane_of_rules));
            assert (read_is_lane == (lane_of(now_1) == lane_of_rules));
            // Lemmas: the parts of a turn step follow one another, with one turn.
            assert (part == 0 || now_1 == probe_now - 1'b1);
            assert (now_1[1:0] == 0 || (now_2 == now_1 - 1'b1 && turn_of_2 == (which_of(now_1) == 0 ? probe_middle
                                        : which_of(now_1) == 1 ? probe_above : probe_below)));
            assert (now_2[1:0] == 0 || (now_3 == now_2 - 1'b1 && turn_of_3 == turn_of_2));
            assert (now_3[1:0] == 0 || (now_4 == now_3 - 1'b1 && turn_of_4 == turn_of_3));
            assert (now_4[1:0] == 0 || (now_5 == now_4 - 1'b1 && turn_of_5 == turn_of_4));
            // The multiplier gets the words of the lane, if they have not changed, and the turn of the item.
            assert (!is_clean(now_1, 1) || (read_step == step[bank_of(now_1)] && read_offset == offset[bank_of(now_1)]));
            factors_of_the_lane: assert (!is_clean(now_2, 2) || (probe_part_2 == $signed({1'b0, part_of(step[bank_of(now_2)], now_2[1:0])})
                                            && probe_offset_2 == offset[bank_of(now_2)]));
            assert (up_after <= HALF_TURN && down_after <= HALF_TURN);
            assert (follows(probe_middle, place == 0 ? SWEEP : place));
            assert (follows(middle, stored_place + WRITTEN));
            assert (follows(middle_before, stored_place + WRITTEN + SWEEP));
            assert (is_near(turn_2, turn_1) && is_near(turn_2, probe_middle) && is_near(turn_2, middle));
            assert (is_near(middle, middle_before) && is_near(probe_middle, middle));
            // Lemmas: the copy, and the clocks until `swept`.
            assert (age[0] != 0 && age[1] != 0);
            assert (!probe_copying || got || probe_copied || probe_copy_left > clocks_to_copy);
            assert (!(probe_copied && probe_to_lane == lane_of_rules) || {probe_to_high, probe_to_low} == step[!idle_bank]);
            assert (probe_copied || !got || !copies || step[0] == step[1]);
            assert (probe_copying == (probe_copy_left != 0) && copies == (probe_copying || probe_copied));
            assert (age[idle_bank] + probe_sweep_left >= OLD + 3 && age[!idle_bank] >= OLD + 3);
            assert (!swept || probe_sweep_left == 0);

            cover (turn_1 == 1 && turn_2 == 0 && !untouched[0] && swept && idle_bank);
            cover (stores && step[bank] != 0 && age[bank] > READ);
            cover (copies_then && !copies && untouched != 3);
        end
    end

endmodule
