// SPDX-License-Identifier: Apache-2.0
//
// The place stays between -width and width, and moves by the motion outside of the dead zone until it stops there. The
// references are written in another form than the VHDL: the place first moves and is then limited; the play is the
// distance of two positions. Once the place is known, it is the reference's place, whichever place between -width and
// width the reference had at the reset or at the last change of the width. Source: the entity's header.

module stop_operator_rules (
    input clock, input reset, input [31:0] position, input [15:0] put_back, input [23:0] width,
    input [7:0] dead_zone, input signed [25:0] any_place
);

    wire signed [24:0] place;
    wire known;

    stop_operator stop (
        .clock(clock), .reset(reset), .position(position), .put_back(put_back), .width(width),
        .dead_zone(dead_zone), .place(place), .known(known)
    );

    wire signed [25:0] probe_low, probe_high, probe_way, probe_to_top, probe_to_bottom;
    wire [23:0] probe_width_before;
    wire signed [4:0] probe_step;
    wire [7:0] probe_slack;
    wire signed [9:0] probe_motion;

    reg running = 0;
    reg [23:0] width_then = 0, width_before_then = 0;
    // The references: the place, and the position that the play follows with its distance.
    reg signed [25:0] reference = 0, reference_then = 0;
    reg signed [11:0] leads = 0; // position before the play minus position behind it
    reg signed [9:0] motion = 0, motion_then = 0;

    wire signed [25:0] top = $signed({2'b0, width});
    wire signed [25:0] goes = reference + $signed({{12{motion_then[9]}}, motion_then, 4'b0});
    wire signed [11:0] zone = $signed({4'b0, dead_zone});
    wire signed [11:0] ahead = leads + probe_step;
    // Behind the play: it moves only if the position leaves the zone.
    wire signed [11:0] pushed = ahead < 0 ? ahead : ahead > zone ? ahead - zone : 12'sd0;
    wire begins = reset || width != width_then;

    always @(posedge clock) begin
        running <= 1;
        width_then <= width;
        width_before_then <= width_then;
        reference <= begins ? any_place : goes > top ? top : goes < -top ? -top : goes;
        reference_then <= reference;
        leads <= reset ? 12'sd0 : ahead - pushed;
        motion <= reset ? 10'sd0 : pushed[9:0];
        motion_then <= motion;
    end

    always @* begin
        assume (running || reset);
        assume (any_place <= top && any_place >= -top);
        if (running) begin
            within_the_width: assert (width_then != width_before_then || width != width_then
                                      || (place <= top && place >= -top));
            as_the_operator: assert (!known || place == reference_then);
            small_steps_only: assert (probe_step <= 8 && probe_step >= -8);

            // Lemmas.
            assert (probe_width_before == width_then);
            assert (probe_motion == motion && probe_slack == leads);
            assert (probe_way == $signed({{12{motion_then[9]}}, motion_then, 4'b0}));
            assert (probe_to_top == $signed({2'b0, width_then}) - probe_way);
            assert (probe_to_bottom == -$signed({2'b0, width_then}) - probe_way);
            assert (probe_low <= reference && reference <= probe_high);
            assert (-$signed({2'b0, width_then}) <= probe_low && probe_high <= $signed({2'b0, width_then}));
            assert (-$signed({2'b0, width_before_then}) <= place && place <= $signed({2'b0, width_before_then}));
            assert (place >= reference_then);

            cover (known && place == top && top == 40);
            cover (known && place == -8 && top == 40);
        end
    end

endmodule
