// SPDX-License-Identifier: Apache-2.0
//
// The entity's difference of two angles below the turn equals their true difference modulo the turn and is at most
// half a turn, for any turn of 4 to 2^24 counts and a new pair of angles in every clock. Source: the entity's header.

module turn_difference_rules (
    input clock, input [23:0] minuend, input [23:0] subtrahend
);

    (* anyconst *) wire [24:0] turn;
    wire signed [24:0] difference;

    turn_difference shorter_way (
        .clock(clock), .minuend(minuend), .subtrahend(subtrahend), .counts_per_rev(turn),
        .difference(difference)
    );

    reg [2:0] running = 0;
    reg [23:0] minuend_1, minuend_2, minuend_3, subtrahend_1, subtrahend_2, subtrahend_3;

    always @(posedge clock) begin
        running <= {running, 1'b1};
        {minuend_3, minuend_2, minuend_1} <= {minuend_2, minuend_1, minuend};
        {subtrahend_3, subtrahend_2, subtrahend_1} <= {subtrahend_2, subtrahend_1, subtrahend};
    end

    // One bit more than a sum of three of these numbers needs.
    wire signed [27:0] whole = $signed({4'd0, minuend_3}) - $signed({4'd0, subtrahend_3});
    wire signed [27:0] found = difference;
    wire signed [27:0] around = $signed({3'd0, turn});

    always @* begin
        assume (turn >= 4 && turn <= 25'h1000000);
        assume (minuend < turn && subtrahend < turn);
        if (running[2]) begin
            same_angle: assert (found == whole || found == whole + around || found == whole - around);
            shorter_way_round: assert (2 * found < around && 2 * found >= -around);

            cover (found == whole + around);
            cover (found == whole - around);
            cover (2 * found == -around);
        end
    end

endmodule
