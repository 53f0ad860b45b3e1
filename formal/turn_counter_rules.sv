// SPDX-License-Identifier: Apache-2.0
//
// Turn number and angle together form an unwrapped angle over many turns. From one accepted angle to the next, the
// unwrapped angle moves by the difference of the two the shorter way round, at most half a turn, also at a wrap. The
// rules hold for any turn of 4 to 2**ANGLE counts and any sequence of angles, accepted in any clocks.
// scripts/formal_proofs states the numbers of bits. Source: the entity's header.

module turn_counter_rules (
    input clock, input reset, input take, input [11:0] angle
);

    localparam ANGLE = 12;
    localparam NUMBER = 8;

    (* anyconst *) wire [ANGLE:0] turn;
    wire [1:0] turn_select;
    wire signed [NUMBER - 1:0] number;

    turn_counter counter (
        .clock(clock), .reset(reset), .take(take), .angle(angle), .counts_per_rev(turn),
        .turn_select(turn_select), .turn(number)
    );

    wire signed [ANGLE + 1:0] probe_half, probe_lowest, probe_highest;
    wire probe_up, probe_down;

    reg [2:0] running = 0;
    // The last angle that was taken and the one before it, both also one clock ago; whether an angle was taken one
    // clock ago, and two clocks ago.
    reg [ANGLE - 1:0] last = 0, before = 0, last_then = 0, before_then = 0;
    reg taken = 0, taken_then = 0, reset_then = 1, reset_before = 1;
    reg signed [NUMBER - 1:0] number_then = 0;
    reg [1:0] select_then = 0;
    reg up_then = 0, down_then = 0;

    always @(posedge clock) begin
        running <= {running, 1'b1};
        taken <= take;
        taken_then <= taken;
        {last_then, before_then} <= {last, before};
        if (take) begin
            last <= angle;
            before <= last;
        end
        number_then <= number;
        select_then <= turn_select;
        up_then <= probe_up;
        down_then <= probe_down;
        reset_then <= reset;
        reset_before <= reset_then;
    end

    wire signed [ANGLE + 3:0] around = $signed({3'd0, turn});
    // The change of the turn number, and the movement from before_then to last_then without and with this change.
    wire signed [NUMBER - 1:0] wraps = number - number_then;
    wire signed [ANGLE + 3:0] without = $signed({4'd0, last_then}) - $signed({4'd0, before_then});
    wire signed [ANGLE + 3:0] moved = without + (wraps == 1 ? around : wraps == 0 ? 0 : -around);
    wire signed [ANGLE + 3:0] half = around >>> 1;

    always @* begin
        assume (turn >= 4 && turn <= 1 << ANGLE);
        assume (angle < turn);
        // In the first three clocks the reset is high and an angle is taken in each clock.
        assume (running[2] || (reset && take));

        // Lemmas: the limits belong to the last angle; up and down are the results of its comparison, up_then and
        // down_then those of one clock ago.
        assert (last < turn && before < turn && last_then < turn && before_then < turn);
        if (running[0]) assert (probe_half == $signed({2'd0, turn[ANGLE:1]}));
        if (running[1]) begin
            assert (probe_lowest == $signed({2'd0, last}) - probe_half);
            assert (probe_highest == $signed({2'd0, last}) + probe_half);
        end
        if (running[2]) begin
            assert (probe_up == (!reset_then && taken && $signed({2'd0, last}) < $signed({2'd0, before}) - probe_half));
            assert (probe_down == (!reset_then && taken && $signed({2'd0, last}) > $signed({2'd0, before}) + probe_half));
            assert (!(probe_up && probe_down) && !(up_then && down_then));
            if (!reset_then) assert (wraps == (up_then ? 1 : down_then ? -1 : 0));
            if (!reset_then && !reset_before) begin
                assert (up_then == (taken_then && without < -half));
                assert (down_then == (taken_then && without > half));
            end

            if (!reset_then) begin
                one_turn_at_most: assert (wraps == 1 || wraps == 0 || wraps == -1);
                only_with_an_angle: assert (taken_then || wraps == 0);
                select_is_the_turns: assert (select_then == number[1:0]);
                if (!reset_before)
                    shorter_way_round: assert (!taken_then || (2 * moved <= around && 2 * moved >= -around));
            end else begin
                reset_is_turn_0: assert (number == 0);
            end

            cover (number == 2 && last == 3);
            cover (number == -2);
            cover (taken_then && wraps == 1 && 2 * moved == around - 1);
        end
    end

endmodule
