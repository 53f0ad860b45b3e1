// SPDX-License-Identifier: Apache-2.0
//
// quadrature_output never changes A and B together, whatever comes in; the reset itself, which sets
// both low, is excepted. Source: the entity's header, "Edges".

module quadrature_output_rules (
    input clock, input reset, input enable, input clear,
    input [31:0] corrected_position, input [23:0] corrected_angle, input [24:0] counts_per_rev,
    input [15:0] minimum_spacing, input [15:0] following_limit
);

    wire a, b, z, cannot_keep_up;
    wire [31:0] following_error;

    quadrature_output edges (.*);

    reg running = 0;
    reg compare = 0;
    reg a_before, b_before;

    always @(posedge clock) begin
        running <= 1;
        compare <= !reset;
        a_before <= a;
        b_before <= b;
    end

    always @* begin
        assume (running || reset);
        if (compare) assert (a == a_before || b == b_before);
    end

endmodule
