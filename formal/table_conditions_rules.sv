// SPDX-License-Identifier: Apache-2.0
//
// Each condition is a factor between -1 and 1, for any motion of the table: stop_operator and table_speed are left out,
// so their outputs may have any value. `step`, the counter of the sweep, and the registers of the divider may have any
// value in any clock, too. Width, dead zone and nominal speed change together at a swap, to the words whose writes are
// acknowledged. A swap that waits for `settled` finds the idle bank's speed and amplitudes ready. Source: the entity's
// header.

module table_conditions_rules (
    input clock, input reset, input read_enable, input write_enable, input [3:0] address,
    input [31:0] write_data, input hold_writes, input swap_comes, input [17:0] speed_squared
);

    localparam ONE = 1 << 16;
    localparam LAST_STEP = 143;

    wire done, settled;
    wire [31:0] read_data;
    wire [7:0] sweep_step;
    wire signed [17:0] direction, speed, idle_speed, word_a, word_b;

    table_conditions conditions (
        .clock(clock), .reset(reset), .read_enable(read_enable), .write_enable(write_enable),
        .address(address), .write_data(write_data), .done(done), .read_data(read_data),
        .hold_writes(hold_writes), .swap_comes(swap_comes), .settled(settled),
        .sweep_step(sweep_step), .direction(direction), .speed(speed), .idle_speed(idle_speed),
        .word_a(word_a), .word_b(word_b), .speed_squared(speed_squared)
    );

    wire [23:0] probe_width, probe_idle_width;
    wire [7:0] probe_dead_zone, probe_idle_dead_zone;
    wire [31:0] probe_nominal, probe_idle_nominal;
    wire probe_pending, probe_divided;
    wire [16:0] probe_ratio, probe_speed_size, probe_idle_size;
    wire signed [17:0] probe_target_a, probe_target_b, probe_real_direction;
    wire signed [34:0] probe_fine_direction, probe_fine_a, probe_fine_b;
    wire [1:0] probe_ends;

    reg running = 0;
    // The references: the active words, and the idle words after the last acknowledged write.
    reg [63:0] active = 0, idle = 0, idle_then = 0;
    reg waits = 0, under_way = 0, held = 0;
    reg [3:0] address_then = 0;
    reg [31:0] data_then = 0;
    reg [1:0] ends = 3; // sweeps that have ended since the last write of an idle word

    // In the clock of `done` the write has taken place.
    wire written = waits && done;
    wire [63:0] idle_now = !written ? idle
                         : address_then == 0 ? {data_then[23:0], idle[39:0]}
                         : address_then == 1 ? {idle[63:40], data_then[7:0], idle[31:0]}
                         : {idle[63:32], data_then};
    wire starts_banked = write_enable && address < 3;

    always @(posedge clock) begin
        running <= 1;
        idle <= idle_now;
        if (swap_comes) active <= idle_now;
        waits <= !reset && (starts_banked || (waits && !done));
        under_way <= !reset && (read_enable || write_enable || (under_way && !done));
        held <= hold_writes;
        address_then <= address;
        data_then <= write_data;
        if (written) ends <= sweep_step == LAST_STEP;
        else if (sweep_step == LAST_STEP && ends < 3) ends <= ends + 1;
    end

    function is_factor(input signed [17:0] value);
        is_factor = value <= ONE && value >= -ONE;
    endfunction

    function is_fine_factor(input signed [34:0] value);
        is_fine_factor = value <= 35'sd4294967296 && value >= -35'sd4294967296;
    endfunction

    always @* begin
        assume (running || reset);
        // The bus makes one access at a time and keeps address and data until `done`.
        assume (!(read_enable && write_enable));
        assume (!(read_enable || write_enable) || !under_way || done);
        assume (!under_way || done || (address == address_then && write_data == data_then));
        // A swap takes place only after its request, which holds the writes, and after `settled`.
        assume (!swap_comes || (hold_writes && settled));
        if (running) begin
            direction_is_a_factor: assert (is_factor(direction));
            speeds_are_factors: assert (is_factor(speed) && is_factor(idle_speed));
            words_are_factors: assert (is_factor(word_a) && is_factor(word_b));
            active_words_together: assert ({probe_width, probe_dead_zone, probe_nominal} == active);
            idle_words_as_written: assert ({probe_idle_width, probe_idle_dead_zone, probe_idle_nominal} == idle_now);
            no_write_while_held: assert (!written || !held);
            // The second end of a sweep begins the sweep of the amplitudes, the third ends it.
            settled_after_the_sweeps: assert (!settled || ends == 3);

            // Lemmas.
            assert (probe_ends == (written ? 0 : ends) && settled == (probe_ends == 3));
            assert (!probe_divided || probe_ratio <= ONE);
            assert (probe_speed_size <= ONE && probe_idle_size <= ONE);
            assert (is_factor(probe_target_a) && is_factor(probe_target_b) && is_factor(probe_real_direction));
            assert (is_fine_factor(probe_fine_direction) && is_fine_factor(probe_fine_a) && is_fine_factor(probe_fine_b));
            assert (!probe_pending || (waits && !done));
            assert (!waits || done || probe_pending);
            assert (!waits || under_way);
            assert (!waits || address_then < 3);

            cover (speed == ONE);
            cover (word_a == -ONE && word_b == 5);
            cover (swap_comes && probe_idle_width != probe_width && probe_idle_nominal != probe_nominal);
            cover (waits && hold_writes && !swap_comes);
        end
    end

endmodule
