// SPDX-License-Identifier: Apache-2.0
//
// The limits of the ramp: the remainder r moves with a velocity that never rises above the rate, and this velocity
// changes by one step of the acceleration at a time. If a marker comes while r stands, r decays from the value that was
// latched to 0, ends there and stays there; it passes 0 by one unit at most. The rules hold for any correction and any
// sequence of markers, counts, resets and rates. `excess` is -r, in units of its last bit. A tick is the time between
// two changes of the velocity. scripts/formal_proofs states the numbers of bits and the length of a tick.
// Source: headers of correction_ramp and ramp_velocity.

module correction_ramp_rules (
    input clock, input reset, input signed [30:0] correction, input marker,
    input signed [15:0] withdrawn, input [1:0] rate
);

    localparam LOOK = 9; // clock of a tick in which the excess is read
    localparam LAST = 15; // last clock of a tick, in which the velocity changes
    localparam MOST = 12; // largest velocity, and largest number of steps to it
    // By how much, in units / 16, r may fall short of the braking distance: 8 clocks pass from the reading of the excess
    // to the new velocity, for which the margin lacks 8 at odd distances, and the fraction has 15.
    localparam SLACK = 23;
    // Largest |excess|: a correction of 2**20 counts, a total of 2**19 and the longest braking distance.
    localparam signed [39:0] FARTHEST = 3 * (40'd1 << 29) + 34;

    (* anyconst *) wire [18:0] limit;
    (* anyconst *) wire [3:0] acceleration;
    wire at_once = acceleration == 0;

    wire signed [29:0] total;

    correction_ramp ramp (
        .clock(clock), .reset(reset), .correction(correction), .marker(marker),
        .withdrawn(withdrawn), .limit(limit), .ramp_rate({30'd0, rate}),
        .ramp_acceleration({28'd0, acceleration}), .total(total)
    );

    wire signed [32:0] probe_excess, probe_next_excess;
    wire [1:0] probe_marker_then;
    wire probe_is_at_rest, probe_stops_at_zero;
    wire signed [29:0] probe_step;
    wire probe_step_rises, probe_falling, probe_ends, probe_moves, probe_is_at_once;
    wire [33:0] probe_velocity;
    wire [3:0] probe_tick, probe_moment;
    wire [32:0] probe_way, probe_way_straight, probe_way_faster, probe_way_same, probe_size;
    wire [32:0] probe_way_less;
    wire [34:0] probe_faster, probe_slower;
    wire probe_takes_off, probe_of_margin, probe_of_same, probe_of_way_back;
    wire probe_is_faster_too_fast, probe_is_too_fast, probe_is_stale, probe_is_zero, probe_goes_away;
    wire probe_is_last, probe_is_slow, probe_brakes, probe_stops, probe_speeds, probe_is_end;
    wire probe_is_short_of_faster, probe_is_short_of_same;
    wire [3:0] probe_fraction;
    wire probe_was_marker;

    // The references of ramp_velocity: the velocity after each number of steps, and the braking distance from it.
    wire [7:0] velocities [0:MOST];
    wire [5:0] ways [0:MOST];
    genvar k;
    generate
        assign velocities[0] = 0;
        assign ways[0] = 0;
        for (k = 1; k <= MOST; k = k + 1) begin : levels
            assign velocities[k] = velocities[k - 1] + acceleration;
            assign ways[k] = ways[k - 1] + velocities[k][7:2];
        end
    endgenerate

    reg running = 0;
    reg [3:0] level = 0; // number of steps of the velocity
    reg [3:0] tick = 0;
    // The rates with which a higher velocity, and one clock later the present velocity, are compared
    reg [1:0] rate_met = 0, rate_kept = 0;
    reg signed [32:0] looked = 0; // the excess as it was read
    reg stale = 0; // the excess has changed since
    // The ramp has compared the excess with the braking distance since the last marker, and moves.
    reg led = 0;
    reg signed [32:0] caught = 0; // the excess that was latched after the last marker
    reg calm = 1; // the ramp stood when it was latched

    wire [5:0] velocity = at_once ? probe_velocity : velocities[level];
    wire [3:0] whole = velocity[5:2]; // the distance of a tick, in units
    wire [5:0] way = ways[level];
    wire [5:0] more = velocity + acceleration;
    wire signed [5:0] less = velocity - acceleration;
    wire [3:0] bound = {rate_met, 2'b00};
    wire [3:0] bound_kept = {rate_kept, 2'b00};
    wire catches = probe_marker_then[1];
    wire unknown = stale || catches;

    // The decision on the next velocity.
    wire [32:0] size = looked < 0 ? ~looked : looked;
    wire away = level != 0 && (probe_falling ? looked < 0 : looked >= 0);
    wire is_zero = looked == 0 || looked == -1 && !away;
    wire for_faster = size >= way + more[5:2] + more[5:3];
    wire for_same = size >= way + whole[3:1];
    wire brakes = velocity > bound_kept || away || !for_same;
    wire ends = (level == 0 && !for_faster) || (is_zero && whole <= 1);
    wire stops = ends || (brakes && level <= 1);
    wire speeds = for_faster && more <= bound && !brakes;
    wire [3:0] next_level = at_once ? 0 : tick != LAST ? level
        : unknown ? (level <= 1 ? 0 : level - 1)
        : stops ? 0 : brakes ? level - 1 : speeds ? level + 1 : level;

    // The excess in the direction of motion: `left` in units, `fine` in units / 16 with the fraction that is carried,
    // `lands` where it ends if the ramp brakes now. Products and sums have few bits, because a solver needs longer for
    // wide ones.
    wire signed [31:0] change = probe_step + $signed({1'b0, !probe_step_rises});
    wire signed [1:0] pending = change != 0 ? 2'sd1 : 2'sd0;
    wire signed [33:0] left = probe_falling ? probe_next_excess : -probe_next_excess;
    wire signed [33:0] looked_left = probe_falling ? looked : -looked;
    wire signed [5:0] fraction = {2'b00, probe_fraction};
    wire signed [5:0] distance = {2'b00, whole};
    wire signed [6:0] braking = {1'b0, way};
    wire signed [5:0] remaining = 6'sd16 - $signed({2'b00, tick});
    wire signed [35:0] after = left - pending;
    wire signed [39:0] fine = $signed({after, 4'd0}) - fraction;
    wire signed [9:0] rest_of_tick = remaining * distance;
    wire signed [9:0] since_look = ($signed({2'b00, tick}) - 6'sd8) * distance;
    wire signed [9:0] below_level = braking - distance;
    wire signed [9:0] to_rest = rest_of_tick + (below_level <<< 4);
    wire signed [39:0] lands = fine - to_rest;

    // One and two clocks ago.
    reg marker_1 = 0, marker_2 = 0, reset_1 = 1, catches_1 = 0, catches_2 = 0, rested_1 = 1, ends_1 = 0, ended_1 = 0;
    reg [1:0] rate_1 = 0, rate_met_1 = 0, rate_kept_1 = 0;
    reg [5:0] velocity_1 = 0;
    reg [3:0] fraction_1 = 0;

    // At the end r may jump to 0 from one unit, or from the distance that is too short to start for.
    wire [2:0] too_short = acceleration[3:2] + acceleration[3:3];
    wire signed [3:0] end_step = too_short > 1 ? {1'b0, too_short} : 4'sd1;
    wire signed [6:0] moved = {3'd0, fraction_1} + velocity_1[5:2];

    always @(posedge clock) begin
        running <= 1;
        tick <= tick + 1;
        level <= next_level;
        if (tick == 2) rate_met <= rate;
        if (tick == 3) rate_kept <= rate;
        if (tick == LOOK) begin
            looked <= probe_next_excess;
            stale <= 0;
        end
        if (tick == LAST && !unknown && !brakes) led <= 1;
        if (catches) begin
            stale <= 1;
            led <= 0;
            calm <= level == 0;
            caught <= correction - total;
        end
        if (next_level == 0) led <= 0;
        marker_1 <= marker && !reset;
        marker_2 <= marker_1 && !reset;
        reset_1 <= reset;
        catches_1 <= catches;
        catches_2 <= catches_1;
        rested_1 <= probe_is_at_rest;
        ends_1 <= probe_ends && !reset;
        ended_1 <= tick == LAST && !unknown && is_zero && whole <= 1;
        rate_1 <= rate;
        rate_met_1 <= rate_met;
        rate_kept_1 <= rate_kept;
        velocity_1 <= probe_velocity;
        fraction_1 <= probe_fraction;
        if (reset) begin
            tick <= 0;
            level <= 0;
            led <= 0;
            calm <= 1;
            caught <= 0;
        end
    end

    always @* begin
        assume (running || reset);

        // Lemmas: the excess has room for its value.
        assert (caught >= -FARTHEST + 34 && caught <= FARTHEST - 34);
        assert (probe_next_excess >= -FARTHEST && probe_next_excess <= FARTHEST);
        assert (probe_excess >= -FARTHEST && probe_excess <= FARTHEST);

        if (running) begin
            // The limits of velocity and acceleration. At the end of the ramp the velocity may fall to 0 from one unit
            // per tick; with an acceleration of 0 it is the rate.
            velocity_step: assert (at_once || probe_velocity == velocity_1 || reset_1
                || tick == 0 && (probe_velocity == velocity_1 + acceleration || probe_velocity + acceleration == velocity_1
                                 || probe_velocity == 0 && (velocity_1 <= acceleration || ended_1 && velocity_1 < 8)));
            velocity_limit: assert (at_once || probe_velocity <= velocity_1 || probe_velocity <= {rate_met_1, 2'b00});
            slows_to_the_rate: assert (at_once || tick != 0 || probe_velocity < velocity_1 || velocity_1 <= {rate_kept_1, 2'b00}
                || reset_1 || velocity_1 == 0);
            rate_at_once: assert (!at_once || probe_velocity == (reset_1 ? 0 : {rate_1, 2'b00}));

            // The excess moves with the velocity: the fraction of a unit is carried.
            moves_with_velocity: assert (reset_1 || catches_1 || catches_2 || $signed({pending, 4'd0}) + fraction == moved);

            // r decays from the latched value to 0.
            if (at_once) begin
                if (!catches_1) begin
                    if (caught >= 0) never_passes_0: assert (probe_excess >= 0 && probe_excess <= caught);
                    else never_passes_0_upwards: assert (probe_excess <= 0 && probe_excess >= caught);
                end
            end else if (calm) begin
                if (caught >= 0) decays: assert (probe_next_excess >= -1 && (probe_next_excess <= 1 || probe_next_excess <= caught));
                else decays_upwards: assert (probe_next_excess <= 1 && (probe_next_excess >= -1 || probe_next_excess >= caught));
            end
            if (led) no_overshoot: assert (left >= -1);

            // r arrives: in each tick without a marker it falls, or the velocity rises, or the ramp ends. A rate that is
            // too small never moves it.
            if (!at_once && tick == LAST && !unknown && looked != 0 && bound >= acceleration + 4 && bound_kept >= acceleration + 4)
                arrives: assert (whole != 0 || next_level > level || ends || away);
            if (!at_once && tick == LAST && !unknown && away) turns_back: assert (next_level < level);
            ends_near_0: assert (!probe_ends || probe_next_excess <= end_step && probe_next_excess >= -end_step);
            ends_at_0: assert (!ends_1 || catches_1 || probe_is_at_rest);
            stays: assert (!rested_1 || catches_1 || reset_1 || probe_is_at_rest && probe_excess == 0);

            // Lemmas: clocks, markers and the state at rest.
            assert (probe_tick == tick);
            assert (probe_moment == (tick < 4 ? tick : tick < LOOK ? 11 : tick - LOOK + 4));
            assert (probe_is_at_once == at_once);
            assert (probe_marker_then == {marker_1, marker_2});
            assert (probe_was_marker == catches_1);
            assert (!catches_1 || marker_2 || reset_1);
            assert (!catches_1 || probe_next_excess == caught);
            assert (!reset_1 || probe_is_at_rest);
            assert (!probe_is_at_rest || (probe_next_excess == 0 && probe_excess == 0));
            assert (!probe_ends || (level == 0 && tick == 0 && !at_once));
            assert (change == 0 || change == 1 || change == -1);
            assert (!probe_was_marker || (change == 0 && probe_fraction == 0));

            // Lemmas: the velocity and the decision on the next one.
            assert (probe_moves == (level != 0));
            assert (level <= MOST && velocities[level] <= MOST);
            assert (probe_way == way);
            assert (probe_takes_off == (tick == 1));
            assert (probe_of_margin == (tick == 3));
            assert (probe_of_same == (tick == LOOK + 3));
            assert (probe_of_way_back == (tick == LOOK + 5));
            assert (!led || level != 0);
            if (at_once) begin
                assert (level == 0);
                assert (probe_is_at_rest || probe_stops_at_zero == !catches_1);
                assert (probe_is_at_rest || change == 0 || change == (caught >= 0 ? -1 : 1));
                assert (probe_is_at_rest || probe_was_marker || probe_falling == (caught >= 0));
                if (caught >= 0) assert (probe_next_excess >= -1 && probe_next_excess <= caught);
                else assert (probe_next_excess <= 0 && probe_next_excess >= caught);
            end else begin
                assert (!probe_stops_at_zero);
                assert (probe_velocity == velocity);
                assert (!probe_is_at_rest || (level == 0 && change == 0));
                assert (level != 0 || tick == 0 || change == 0);
                assert (change == 0 || change == (probe_falling ? -1 : 1));
                if (tick >= 1) begin
                    assert (probe_faster == more);
                    assert ($signed({pending, 4'd0}) + fraction <= distance + 15);
                end
                if (tick >= 2) assert ($signed(probe_slower) == less);
                if (tick >= 3) begin
                    assert (probe_is_last == (level <= 1));
                    assert (probe_is_slow == (whole <= 1));
                    assert (probe_is_faster_too_fast == (more > bound));
                    assert (probe_way_straight == way + more[5:2]);
                end
                if (tick >= 4) begin
                    assert (probe_is_too_fast == (velocity > bound_kept));
                    assert (probe_way_same == way + whole[3:1]);
                    assert (probe_way_faster == way + more[5:2] + more[5:3]);
                end
                if (tick > LOOK) begin
                    assert (probe_is_stale == stale);
                    if (tick == LOOK + 1) assert ($signed(probe_size) == looked);
                    if (tick > LOOK + 1) begin
                        assert (probe_size == size);
                        assert (probe_goes_away == away);
                        if (tick == LOOK + 2) assert (probe_is_zero == (looked == 0));
                    end
                    if (tick > LOOK + 2) begin
                        assert (probe_is_zero == is_zero);
                        assert (probe_is_short_of_faster == !for_faster);
                    end
                    if (tick > LOOK + 3) assert (probe_is_short_of_same == !for_same);
                    if (tick > LOOK + 4) begin
                        assert (probe_brakes == brakes);
                        assert (probe_stops == stops);
                        assert (probe_speeds == speeds);
                        assert (probe_is_end == ends);
                        assert (tick != LAST || level == 0 || probe_way_less == way - whole);
                    end
                    if (!stale) begin
                        if (level == 0) assert (probe_next_excess == looked);
                        else assert (left <= looked_left && fine >= $signed({looked_left, 4'd0}) - since_look - 15);
                    end
                end

                // Lemmas: where the excess lands if the ramp brakes.
                if (led) assert (lands >= -SLACK);
                if (level != 0) assert (lands >= -(FARTHEST <<< 4) + 40);
                if (level == 0 && pending != 0) assert (fine >= -(FARTHEST <<< 4) + 40);
                if (calm && level != 0) assert (led);
                if (calm && level == 0 && pending != 0) assert (fine >= -SLACK);
                if (calm && (level != 0 || pending != 0))
                    assert (probe_falling == (caught >= 0) || left <= 1);
            end

            // A ramp that moves, one whose remainder is too small for that, and one without limit of the acceleration.
            cover (!at_once && calm && caught > 2 && led);
            cover (!at_once && calm && caught == -3 && probe_is_at_rest);
            cover (at_once && caught > 0 && probe_is_at_rest);
        end
    end

endmodule
