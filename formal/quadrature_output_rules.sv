// SPDX-License-Identifier: Apache-2.0
//
// quadrature_output: for any inputs A and B never change together, and two edges keep the minimum spacing
// that was set when the first of them was decided. A reset ends the spacing, but does not change A and B. The levels of
// A and B belong to the output's count. Z never rises on an angle without reference; a gated Z never rises outside the
// set state of A and B. After a fault the output does not move until the fault is cleared. Source: the entity's header,
// "Edges", "Phase", "Z" and "Fault".

module quadrature_output_rules (
    input clock, input reset, input enable, input clear,
    input [31:0] corrected_position, input [23:0] corrected_angle, input referenced,
    input [1:0] phase_of_zero, input z_gated, input [1:0] z_state, input [1:0] z_width,
    input [24:0] counts_per_rev,
    input [15:0] minimum_spacing, input [15:0] following_limit
);

    wire pin_a, pin_b, pin_z, cannot_keep_up;
    wire [31:0] following_error;
    // The pins may have any polarity and direction, which are undone here.
    (* anyconst *) reg invert_a, invert_b, invert_z, swap_ab;

    quadrature_output edges (.a(pin_a), .b(pin_b), .z(pin_z), .*);

    wire first = pin_a ^ invert_a, second = pin_b ^ invert_b;
    wire a = swap_ab ? second : first, b = swap_ab ? first : second;
    wire z = pin_z ^ invert_z;

    // Number of clocks from the first clock in which a register holds the decided step to the edge at the pin.
    localparam WAY = 3;
    localparam [16:0] LONG_AGO = 17'h1ffff;

    reg running = 0;
    reg compare = 0;
    reg a_before, b_before;
    reg [WAY - 1:0] resets = 0;
    // minimum_spacing of the earlier clocks; in the oldest one an edge was decided.
    reg [15:0] spacing_of [0:WAY];
    // Clocks since the last edge, and the spacing that applies to it.
    reg [16:0] since = LONG_AGO;
    reg [15:0] asked = 0;

    wire edge_now = compare && (a != a_before || b != b_before);

    integer i;
    always @(posedge clock) begin
        running <= 1;
        compare <= running;
        a_before <= a;
        b_before <= b;
        spacing_of[0] <= minimum_spacing;
        for (i = 0; i < WAY; i = i + 1) spacing_of[i + 1] <= spacing_of[i];
        resets <= {resets[WAY - 2:0], reset};
        // An edge that was in the pipeline during a reset sets no spacing.
        if (edge_now && !resets) since <= 1;
        else if (since != LONG_AGO) since <= since + 1;
        if (edge_now && !resets) asked <= spacing_of[WAY];
        if (reset) begin
            since <= LONG_AGO;
            asked <= 0;
        end
    end

    // An angle has its effect on Z four clocks later.
    reg [3:0] referenced_then = 0;
    reg z_before, gated_then;
    reg [1:0] state_now, width_now, state_then, width_then, phase_now, tie;
    // The last edge before the output stops is decided before the fault is reported.
    reg [4:0] clocks_at_fault = 0;
    always @(posedge clock) begin
        referenced_then <= {referenced_then[2:0], referenced};
        z_before <= z;
        // The entity samples z_state, z_width and phase_of_zero one clock earlier.
        phase_now <= phase_of_zero;
        if (!probe_following) tie <= phase_now;
        {state_now, width_now} <= {z_state, z_width};
        {gated_then, state_then, width_then} <= {z_gated, state_now, width_now};
        clocks_at_fault <= cannot_keep_up ? clocks_at_fault + (clocks_at_fault != 31) : 0;
    end

    // Index of (A, B) in 00, 10, 11, 01.
    wire [1:0] place = {b, a ^ b};
    wire [1:0] behind_state = place - state_then;

    // Clocks since the last decision on an edge, and the spacing that applies to it; a decision gives no edge if
    // `enable` goes low. These numbers connect the claim with the entity's registers, so that the induction succeeds.
    wire [1:0] probe_up, probe_down;
    wire [15:0] probe_spacing;
    wire probe_may_step;
    wire [1:0] probe_phase, probe_phase_then;
    wire [2:0] probe_referenced_then;
    wire [31:0] probe_output;
    wire probe_following;

    wire decided = probe_up[0] || probe_down[0];
    reg [16:0] since_decision [0:WAY];
    reg [15:0] asked_then [0:WAY];
    reg [1:WAY] decided_then = 0;
    wire [16:0] since_now = decided ? 17'd0 : since_decision[0];
    wire [15:0] asked_now = decided ? spacing_of[0] : asked_then[0];

    initial for (i = 0; i <= WAY; i = i + 1) begin
        since_decision[i] = LONG_AGO;
        asked_then[i] = 0;
    end

    always @(posedge clock) begin
        since_decision[0] <= since_now == LONG_AGO ? LONG_AGO : since_now + 1;
        asked_then[0] <= asked_now;
        for (i = 0; i < WAY; i = i + 1) begin
            since_decision[i + 1] <= since_decision[i];
            asked_then[i + 1] <= asked_then[i];
        end
        decided_then <= {decided, decided_then[1:WAY - 1]};
        if (reset) begin
            for (i = 0; i <= WAY; i = i + 1) begin
                since_decision[i] <= LONG_AGO;
                asked_then[i] <= 0;
            end
        end
    end

    always @* begin
        assume (running || reset);
        if (compare) begin
            never_together: assert (a == a_before || b == b_before);
            keeps_spacing: assert (!edge_now || since >= asked);

            needs_a_reference: assert (!z || z_before || referenced_then[3]);
            keeps_its_state: assert (!z || z_before || !gated_then
                                     || behind_state < (width_then == 0 ? 1 : width_then == 1 ? 2 : 4));
            belongs_to_the_count: assert (probe_phase == probe_output[1:0] + tie);
            stands_after_a_fault: assert (clocks_at_fault < 7 || !edge_now);

            // Lemmas.
            assert (probe_referenced_then == referenced_then[2:0]);
            assert (clocks_at_fault < 2 || !probe_following);
            assert (clocks_at_fault < 3 || !decided);
            assert (clocks_at_fault < 4 || !decided_then[1]);
            assert (clocks_at_fault < 5 || !decided_then[2]);
            assert (clocks_at_fault < 6 || !decided_then[3]);
            assert (probe_may_step ? since_now + 1 >= asked_now || since_now == LONG_AGO
                    : probe_spacing >= 2 && since_now < asked_now
                      && probe_spacing == asked_now - since_now);
            assert (!decided || since_decision[0] >= asked_then[0]);
            assert (probe_phase == probe_phase_then || decided_then[1]);
            assert ({a ^ b, b} == {probe_phase_then[0], probe_phase_then[1]} || decided_then[2]);
            assert (!edge_now || decided_then[WAY]);
            assert (since >= asked
                    || (since == since_decision[WAY] && asked == asked_then[WAY]));

            cover (edge_now && since == 3 && asked == 3);
            cover (edge_now && since == 1 && enable);
            cover (z && edge_now);
            cover (clocks_at_fault == 7);
        end
    end

endmodule
