// SPDX-License-Identifier: Apache-2.0
//
// An effective amplitude is the rounded product of the nominal amplitude of its own lane and bank and the modulator
// that this lane has chosen; its magnitude is at most that of the nominal amplitude. The multiplier is not modelled:
// the rules assume only that a factor between -1 and 1 makes no number larger, and that 1 changes none. While `swept`
// is high, the effective amplitudes of both banks belong to their present words. The rules follow one arbitrary lane
// of one bank; the words that the entity reads from its memory are those of this lane. To keep the proof short, a
// sweep may omit steps of other lanes; they do not affect this lane. scripts/formal_proofs states the numbers of
// bits. Source: the entity's header.

module amplitude_sweep_rules #(
    parameter LANES = 2
) (
    input clock, input [7:0] sweep_step, input signed [2:0] direction, input signed [2:0] speed,
    input signed [2:0] idle_speed, input signed [2:0] word_a, input signed [2:0] word_b,
    input write_amplitude, input write_choice, input write_bank, input [5:0] write_lane,
    input [18:0] write_word
);

    localparam WIDTH = 19, ONE = 2;
    localparam SQUARE_STEP = 128, LAST_STEP = 143, STORED_STEP = 134;

    (* anyconst *) wire of_bank;
    (* anyconst *) wire [5:0] of_lane;
    wire [7:0] place = {1'b0, of_bank, of_lane};

    wire signed [2:0] speed_squared;
    wire swept, bank;
    wire [0:LANES - 1] selected;
    wire [2:0] slot;
    wire signed [WIDTH - 1:0] effective;

    amplitude_sweep sweep (
        .clock(clock), .sweep_step(sweep_step), .direction(direction), .speed(speed),
        .idle_speed(idle_speed), .word_a(word_a), .word_b(word_b), .speed_squared(speed_squared),
        .write_amplitude(write_amplitude), .write_choice(write_choice), .write_bank(write_bank),
        .write_lane(write_lane), .write_word(write_word), .swept(swept), .selected(selected),
        .bank(bank), .slot(slot), .effective(effective)
    );

    wire signed [WIDTH - 1:0] probe_nominal_read, probe_amplitude_2;
    wire [2:0] probe_choice_read;
    wire signed [2:0] probe_modulator_2, probe_held_direction, probe_held_a, probe_held_b;
    wire signed [WIDTH + 2:0] probe_product_3;
    wire signed [WIDTH:0] probe_rounded_4;
    wire [31:0] probe_steps;
    wire [5:0] probe_held_speed, probe_held_square, probe_next_speed, probe_next_square;
    wire probe_is_whole;

    reg running = 0;
    reg signed [WIDTH - 1:0] nominal = 0, nominal_read = 0, stored = 0;
    reg [2:0] choice = 0, choice_read = 0;
    reg read_it = 0, is_of_words = 0, whole = 0;
    // High if the lane's item is in this stage and was read from its present words.
    reg [1:5] in_stage = 0;
    reg [7:0] step_1 = 0, step_2 = 0, step_3 = 0, step_4 = 0, step_5 = 0;
    reg [7:0] step_then = 0;
    reg write_bank_then = 0;
    reg signed [2:0] held_direction = 0, held_speed = 0, held_square = 0, held_a = 0, held_b = 0, next_speed = 0;

    wire signed [2:0] modulator = choice == 1 ? held_direction : choice == 2 ? held_speed : choice == 3 ? held_square
                                  : choice == 4 ? held_a : choice == 5 ? held_b : ONE;
    // The product of the entity's multiplier, in stages 3 and 4, its rounding, and the factors one clock ago.
    reg signed [WIDTH + 2:0] product_4 = 0;
    reg signed [WIDTH - 1:0] amplitude_then = 0;
    reg signed [2:0] modulator_then = 0;
    reg signed [WIDTH + 2:0] rounded_5 = 0;
    wire signed [WIDTH + 2:0] rounded_4 = (product_4 + ONE / 2) >>> 1;
    wire signed [WIDTH - 1:0] expected = rounded_5 == 1 << (WIDTH - 1) ? (1 << (WIDTH - 1)) - 1 : rounded_5;
    wire signed [WIDTH + 2:0] largest = (amplitude_then < 0 ? -amplitude_then : amplitude_then) * ONE;

    wire of_rules = write_bank == of_bank && write_lane == of_lane;
    wire writes = (write_amplitude || write_choice) && of_rules;
    wire stores = selected[of_lane] && bank == of_bank;

    always @(posedge clock) begin
        running <= 1;
        step_then <= sweep_step;
        write_bank_then <= write_bank;
        if (write_amplitude && of_rules) nominal <= write_word;
        if (write_choice && of_rules) choice <= write_word[18:16];
        nominal_read <= nominal;
        choice_read <= choice;
        read_it <= sweep_step == place;
        in_stage <= writes ? 5'd0 : {sweep_step == place, in_stage[1:4]};
        {step_1, step_2, step_3, step_4, step_5} <= {sweep_step, step_1, step_2, step_3, step_4};
        if (stores) stored <= effective;
        product_4 <= probe_product_3;
        rounded_5 <= rounded_4;
        amplitude_then <= probe_amplitude_2;
        modulator_then <= probe_modulator_2;
        is_of_words <= !writes && (in_stage[5] || is_of_words);
        whole <= !(write_amplitude || write_choice) && (sweep_step == 0 || whole);
        if (sweep_step == SQUARE_STEP) next_speed <= write_bank == of_bank ? idle_speed : speed;
        if (sweep_step == LAST_STEP) begin
            held_direction <= direction;
            held_speed <= next_speed;
            held_square <= of_square;
            held_a <= word_a;
            held_b <= word_b;
        end
    end

    function is_factor(input signed [2:0] value);
        is_factor = value <= ONE && value >= -ONE;
    endfunction

    wire [WIDTH - 1:0] size = nominal < 0 ? -nominal : nominal;
    wire [WIDTH - 1:0] stored_size = stored < 0 ? -stored : stored;
    wire signed [2:0] of_square = of_bank ? probe_next_square[2:0] : probe_next_square[5:3];

    wire signed [WIDTH + 2:0] limit = size * ONE;

    function is_product(input signed [WIDTH + 2:0] value);
        is_product = value <= limit && value >= -limit && ((choice != 0 && choice < 6) || value == nominal * ONE);
    endfunction

    function is_rounded(input signed [WIDTH + 2:0] value);
        is_rounded = value <= $signed({3'd0, size}) && value >= -$signed({3'd0, size})
                     && ((choice != 0 && choice < 6) || value == nominal);
    endfunction

    genvar k;
    generate
        for (k = 1; k <= 5; k = k + 1) begin : stages
            wire [7:0] step_now = k == 1 ? step_1 : k == 2 ? step_2 : k == 3 ? step_3 : k == 4 ? step_4 : step_5;
            wire [7:0] next = k == 1 ? sweep_step : k == 2 ? step_1 : k == 3 ? step_2 : k == 4 ? step_3 : step_4;
            always @* if (running) begin
                assert (!in_stage[k] || sweep_step < SQUARE_STEP + k);
                assert (step_now < SQUARE_STEP || step_now >= LAST_STEP || next == step_now + 1);
                assert (next <= SQUARE_STEP || step_now == next - 1);
                // If an item was read before the last write, so were all items before it.
                assert (step_now != place || in_stage[k] || (!is_of_words && (in_stage & (31 >> k)) == 0));
            end
        end
    endgenerate

    always @* begin
        assume (of_lane < LANES);
        assume (sweep_step <= LAST_STEP && (running || sweep_step <= SQUARE_STEP));
        // A sweep omits no step from SQUARE_STEP on, and not the steps 0 and `place`.
        assume (!running || (step_then == LAST_STEP ? sweep_step == 0
                             : step_then >= SQUARE_STEP ? sweep_step == step_then + 1
                             : sweep_step > step_then && sweep_step <= SQUARE_STEP
                               && (step_then >= place || sweep_step <= place)));
        assume (is_factor(direction) && is_factor(speed) && is_factor(idle_speed) && is_factor(word_a) && is_factor(word_b));
        assume (!read_it || (probe_nominal_read == nominal_read && probe_choice_read == choice_read));
        // Arithmetic: a factor between -1 and 1 makes no product larger, and 1 changes no amplitude.
        assume (!is_factor(modulator_then) || (probe_product_3 <= largest && probe_product_3 >= -largest));
        assume (modulator_then != ONE || probe_product_3 == amplitude_then * ONE);
        if (running) begin
            product_of_its_words: assert (!in_stage[5] || (stores && effective == expected));
            no_other_writes_it: assert (!stores || step_5 == place);
            never_larger: assert (!is_of_words || stored_size <= size);
            unmodulated_is_nominal: assert (!is_of_words || (choice != 0 && choice < 6) || stored == nominal);
            swept_is_whole: assert (!swept || is_of_words);
            square_is_a_factor: assert (write_bank_then == of_bank || is_factor(speed_squared));

            // Lemmas: the modulators.
            assert (is_factor(next_speed) && is_factor(held_direction) && is_factor(held_speed) && is_factor(held_a)
                    && is_factor(held_b) && is_factor(held_square));
            assert (probe_held_direction == held_direction && probe_held_a == held_a && probe_held_b == held_b);
            assert ((of_bank ? probe_held_speed[2:0] : probe_held_speed[5:3]) == held_speed);
            assert ((of_bank ? probe_held_square[2:0] : probe_held_square[5:3]) == held_square);
            assert ((of_bank ? probe_next_speed[2:0] : probe_next_speed[5:3]) == next_speed);
            assert (is_factor(of_square));
            square_of_its_speed: assert (step_2 != SQUARE_STEP + of_bank
                                         || (probe_modulator_2 == next_speed && probe_amplitude_2 == next_speed));
            assert (step_3 != SQUARE_STEP + of_bank || (probe_product_3 <= ONE * ONE && probe_product_3 >= -ONE * ONE));
            assert (step_4 != SQUARE_STEP + of_bank || (probe_rounded_4 <= ONE && probe_rounded_4 >= -ONE));
            // Lemmas: the stages.
            assert (probe_steps == {step_1, step_2, step_3, step_4});
            assert (step_1 == step_then);
            assert (!in_stage[1] || (step_1 == place && nominal_read == nominal && choice_read == choice && read_it));
            factors_of_its_words: assert (!in_stage[2] || (step_2 == place && probe_amplitude_2 == nominal && probe_modulator_2 == modulator));
            assert (!in_stage[3] || (step_3 == place && amplitude_then == nominal && modulator_then == modulator));
            assert (!in_stage[4] || (step_4 == place && is_product(product_4)));
            assert (!in_stage[5] || (step_5 == place && is_rounded(rounded_5)));
            assert (!in_stage[4] || probe_rounded_4 == rounded_4);
            assert (!(selected[of_lane] && bank == of_bank) || step_5 == place);
            assert (probe_is_whole == whole);
            assert (!whole || sweep_step <= place || is_of_words || in_stage != 0);
            assert (in_stage == 0 || sweep_step < STORED_STEP);

            cover (swept && nominal == -5 && choice == 1 && stored == 5);
            cover (is_of_words && choice == 3 && stored == 2 && nominal == 7);
        end
    end

endmodule
