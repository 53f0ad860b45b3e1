// SPDX-License-Identifier: Apache-2.0
//
// quadrature_decoder counts in the sense of the paper's figure 4, A before B up, from levels of the pins
// that have lasted filter_length clocks; it never moves by more than one count per clock, and reports
// each illegal transition. The reference uses the last samples of the pins and a table; it shares
// no code and no method of counting with the entity. Source: the entity's header.

module quadrature_decoder_rules (
    input clock, input reset, input a, input b, input [7:0] filter_length,
    input zero_again, input heal
);

    wire [31:0] position, put_back;
    wire zero_moved;
    wire step, step_up, illegal;

    // Inputs that are not connected may take any value in any clock.
    quadrature_decoder decoder (
        .clock(clock), .reset(reset), .a(a), .b(b), .filter_length(filter_length),
        .zero_again(zero_again), .heal(heal), .decoded_zero_moved(zero_moved), .decoded_put_back(put_back),
        .decoded_position(position), .decoded_step(step), .decoded_step_up(step_up), .decoded_illegal(illegal)
    );

    localparam LONGEST = 7; // of filter_length
    localparam STAGES = 2; // of the synchroniser

    reg running = 0;
    reg was_reset = 1;
    // The pins and the reset after the synchroniser.
    reg [1:0] pins [1:STAGES];
    reg [1:STAGES] settles = ~0;
    // Earlier samples, latest in bit 0; samples from before the reset count as equal to the level.
    reg [LONGEST - 2:0] samples_a, samples_b;
    reg [1:0] level;
    reg signed [1:0] moved = 0, moved_then = 0;
    reg broke = 0, broke_then = 0;
    reg [31:0] reference = 0, position_before, put_back_before;
    reg zero_moved_before, may_move = 0, may_heal = 0;
    reg [1:0] ab;

    // +1 up, -1 down, 0 neither: the order of the levels is 00, 10, 11, 01.
    function signed [1:0] moves (input [3:0] old_new);
        case (old_new)
            4'b00_10, 4'b10_11, 4'b11_01, 4'b01_00: moves = 1;
            4'b00_01, 4'b01_11, 4'b11_10, 4'b10_00: moves = -1;
            default: moves = 0;
        endcase
    endfunction

    // Whether the newest filter_length samples all differ from the level.
    wire [LONGEST - 1:0] other_a = {samples_a, pins[STAGES][1]} ^ {LONGEST{level[1]}};
    wire [LONGEST - 1:0] other_b = {samples_b, pins[STAGES][0]} ^ {LONGEST{level[0]}};
    wire [LONGEST - 1:0] judged = filter_length <= 1 ? 1 : (1 << filter_length) - 1;
    wire [1:0] new_level = level ^ {&(other_a | ~judged), &(other_b | ~judged)};

    always @(posedge clock) begin
        running <= 1;
        was_reset <= reset;
        pins[1] <= {a, b};
        pins[2] <= pins[1];
        settles <= {1'b0, settles[1:STAGES - 1]};
        samples_a <= {samples_a, pins[STAGES][1]};
        samples_b <= {samples_b, pins[STAGES][0]};
        level <= new_level;
        moved <= moves({level, new_level});
        broke <= &(level ^ new_level);
        if (settles[STAGES]) begin
            samples_a <= {LONGEST{pins[STAGES][1]}};
            samples_b <= {LONGEST{pins[STAGES][0]}};
            level <= pins[STAGES];
            moved <= 0;
            broke <= 0;
        end
        moved_then <= moved;
        broke_then <= broke;
        reference <= reference + {{30{moved_then[1]}}, moved_then};
        position_before <= position;
        put_back_before <= put_back;
        zero_moved_before <= zero_moved;
        may_move <= zero_again;
        may_heal <= heal;
        if (reset) begin
            settles <= ~0;
            moved <= 0;
            broke <= 0;
            moved_then <= 0;
            broke_then <= 0;
            reference <= 0;
        end
    end

    wire [31:0] motion = position - position_before;

    // Lemmas connect the samples with the filter's registers (A, B, Z from the left).
    wire [23:0] probe_lasted;
    wire [2:0] probe_level;

    // 1 plus the number of latest consecutive samples that differ from the level.
    function [7:0] lasted (input [LONGEST - 2:0] samples, input level);
        integer i;
        reg in_a_row;
        begin
            lasted = 1;
            in_a_row = 1;
            for (i = 0; i < LONGEST - 1; i = i + 1) begin
                in_a_row = in_a_row && samples[i] != level;
                lasted = lasted + in_a_row;
            end
        end
    endfunction

    always @* begin
        assume (running || reset);
        assume (filter_length <= LONGEST);
        if (running) begin
            counts_as_reference: assert (position == reference);
            never_jumps: assert (was_reset || motion == 0 || motion == 1 || &motion);
            zero_stays: assert (was_reset || may_move || zero_moved == zero_moved_before);
            puts_nothing_back: assert (was_reset || (may_heal && zero_moved != zero_moved_before)
                                       || put_back == put_back_before);
            tells_steps: assert (was_reset || (step == (motion != 0) && step_up == (motion == 1)));

            assert (settles[STAGES] || probe_level[2:1] == level);
            assert (settles[STAGES] || probe_lasted[23:16] == lasted(samples_a, level[1]));
            assert (settles[STAGES] || probe_lasted[15:8] == lasted(samples_b, level[0]));

            cover (position == 3 && filter_length == 2);
            cover (&position && filter_length == 0);
            cover (illegal && position == 1);
        end
    end

endmodule
