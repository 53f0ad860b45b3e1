-- SPDX-License-Identifier: Apache-2.0
--
-- Defines the number formats of the data path; no other file defines them. `make generate` reads the integer constants
-- below and writes them as a Python module and a C header.
--
-- Notation: u I.F is unsigned with I integer and F fraction bits (I + F bits);
-- s I.F is signed with a sign, I integer and F fraction bits (1 + I + F bits).
--
--   angle             u24.0   counts, 0 <= angle < counts_per_rev
--   counts_per_rev    u25.0   counts, 4 .. 2**24
--   position          s31.0   counts, multi-turn, wraps modulo 2**32
--   lane order        u16.0   harmonic order n, 0 .. 65535
--   phase step K      u0.48   turn per count, K = round(n * 2**48 / counts_per_rev) mod 2**48
--   phase             u0.24   turn
--   cosine            s1.16   b = 18 bits (sections 2.2 and 3.3 and appendix of the paper)
--   amplitude         s13.11  counts, 2 * A_n of equation (9); its 25 bits fit the A port of the DSP48E1
--   pair sum          s15.27  counts, sum of amplitude * cosine of two lanes, with every bit of the products
--   correction        s19.11  counts, the sum of up to 64 lanes
--   head offset       u24.4   counts, reading of a head at the angle of the table where the mean is 0
--   head weight       s1.16   share of a head in the mean; the sum over the heads is 1, as an integer 2**16
--   head difference   s16.4   counts, reading of a head minus reading of the carrier, limited
--   mean term         s19.20  counts, the term that the mean adds to the correction
--   turn number       s23.0   number of turns of the angle; wraps modulo 2**24
--   turn step         u0.48   turns per turn, fractional part of an order n: round(n * 2**48) mod 2**48

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

package number_formats_pkg is

  constant ANGLE_WIDTH                : positive := 24;
  constant COUNTS_PER_REV_WIDTH       : positive := 25;
  constant COUNTS_PER_REV_MIN         : positive := 4;
  constant COUNTS_PER_REV_MAX         : positive := 16777216;
  constant POSITION_WIDTH             : positive := 32;
  constant ORDER_WIDTH                : positive := 16;
  constant PHASE_STEP_WIDTH           : positive := 48;
  constant PHASE_WIDTH                : positive := 24;
  constant COSINE_WIDTH               : positive := 18;
  constant COSINE_FRACTION            : positive := 16;
  constant CORDIC_ITERATIONS          : positive := 16;
  constant AMPLITUDE_WIDTH            : positive := 25;
  constant AMPLITUDE_FRACTION         : positive := 11;
  constant PAIR_WIDTH                 : positive := 43;
  constant PAIR_FRACTION              : positive := 27;
  constant CORRECTION_WIDTH           : positive := 31;
  constant CORRECTION_FRACTION        : positive := 11;

  -- Number of iterations of the CORDIC, from iteration 0 on, that a table replaces. Iteration 0 has one outcome and the
  -- others have two each: 7 iterations have 64 outcomes, so a bit of the table is a function of 6 inputs, one LUT.
  constant TABULATED_ITERATIONS       : positive := 7;
  -- Number of bits of the CORDIC's x below the last bit of the cosine. x is rounded 10 times, once in the table and once
  -- in each of the 9 iterations after it, each time by at most half a unit: with 2 bits, these roundings change the
  -- cosine by at most 5 / 4 of its last bit.
  constant GUARD_WIDTH                : positive := 2;
  -- Number of fraction bits of the CORDIC's x that y does not have; every adder of y is shorter by these bits. Before y
  -- changes x, it is shifted by TABULATED_ITERATIONS bits or more: with 4 bits, a rounding of y (by at most 8 units of
  -- x) changes x by at most 8 / 128 = 1/16 unit. The number must be less than TABULATED_ITERATIONS.
  constant Y_SAVED_WIDTH              : positive := 4;

  -- Bits of the folded phase that address the table of table_rotation, one entry per interval: 128 intervals have the
  -- half width h = 2*pi / 1024, and a line in place of the cosine is wrong by at most h**2 / 4 = 9.4E-6.
  constant COSINE_ADDRESS_WIDTH       : positive := 7;
  -- Number of rows of adders in table_rotation; a row multiplies the slope by 2 bits of the place in an interval. 5 rows
  -- leave 5 bits of the place out, which changes the cosine by at most 2*pi * 2**-20 = 6.0E-6.
  constant COSINE_ROWS                : positive := 5;
  -- Fraction bits of the slopes in table_rotation, u3.8 per turn: the rounding of a slope changes the cosine by at most
  -- 2**-9 times half an interval, 2**-10 turn: 1.9E-6.
  constant COSINE_SLOPE_FRACTION      : positive := 8;
  -- Fraction bits of the values in table_rotation, s1.20: their rounding changes the cosine by at most 2**-21 = 4.8E-7.
  constant COSINE_VALUE_FRACTION      : positive := 20;

  -- Latencies in clocks (Table 1 of the paper).
  constant PHASE_LATENCY              : positive := 5;
  constant HARMONIC_LATENCY           : positive := 20;
  constant COMPENSATION_LATENCY       : positive := 4;
  constant DELAY_LINE_LATENCY         : positive := 25;
  constant PIPELINE_LATENCY           : positive := 29;

  -- Clocks from the readings of the heads: DIFFERENCE_LATENCY to their differences (turn_difference), MEAN_LATENCY to
  -- the term that the mean adds to the correction (weighted_mean).
  constant DIFFERENCE_LATENCY         : positive := 3;
  constant MEAN_LATENCY               : positive := 10;

  -- Bits of a part of a phase step or turn step that one multiplier takes: the narrow port of the DSP48E1 takes 17
  -- unsigned bits.
  constant PHASE_PART_WIDTH           : positive := 17;
  -- Clocks per lane of a sweep of turn_offset_sweep: 3 parts of the turn step for 3 turns, for both banks.
  constant TURN_SWEEP_CLOCKS_A_LANE   : positive := 18;

  -- Clocks from the clock in which the phase unit gets an angle to the clock in which it gets the phase offset; the
  -- adder of the first multiplier adds this offset.
  constant PHASE_OFFSET_CLOCK         : positive := 2;

  -- Clocks from the clock in which the harmonic unit gets a phase to the clock in which it gets the amplitude, which it
  -- multiplies by the finished cosine.
  constant AMPLITUDE_CLOCK            : positive := 16;

  -- Registers in series after each pin: a register that samples a changing pin has one clock to settle.
  constant SYNCHRONISER_STAGES_DEFAULT : positive := 2;
  -- Counts in a period of A and B: each of the four levels of (A, B) is one count.
  constant COUNTS_PER_PERIOD          : positive := 4;
  -- Value at which the counters of faults saturate: they have 16 bits.
  constant FAULT_COUNT_MAX            : positive := 65535;
  -- Largest spacing of edges that is measured, clocks: the register minimum_edge_spacing has 16 bits.
  constant EDGE_SPACING_MAX           : positive := 65535;
  -- Clocks from the detection of an index (stage 2 of index_zero) to its check (stage 5).
  constant INDEX_JUDGED_AFTER         : positive := 3;
  -- Number of bits of a slip of the zero, in counts, that is put back: -2**14 to 2**14 - 1 counts, 0.35 degrees at
  -- 2**24 counts per turn. A larger slip is not put back.
  constant INDEX_HEAL_WIDTH           : positive := 15;

  -- Largest number of clocks by which Z may change before or after its edge of A or B.
  constant INDEX_SKEW                 : positive := 3;

  -- Smallest slope |d eps / d R|, in percent, for which a correction is refused: with it the corrected angle could
  -- decrease while the reading increases.
  constant STEEPEST_PERCENT           : positive := 100;

  -- If the coefficient file states no range, lanes follow the temperature up to this many kelvins above and below T0,
  -- the temperature at which the lanes have their loaded values.
  constant THERMAL_RANGE_K            : positive := 10;

  -- Ramp of the correction: binary logarithm of the clocks between two changes of its velocity. In the last 16
  -- of these 256 clocks the ramp reads its remainder and chooses the next velocity.
  constant RAMP_TICK_WIDTH            : positive := 8;
  -- Fraction bits of the ramp's velocity below those of its rate. One step of the velocity lasts 256 clocks: at the
  -- smallest acceleration, 2**-59 count per clock and clock, it is 2**-51 count per clock, 16 bits below 2**-35.
  constant RAMP_VELOCITY_FRACTION     : positive := 16;
  -- Margin of the braking distance: 2**-3 of the distance of 256 clocks, which is 32 clocks and covers the 15 clocks from
  -- the reading of the remainder to the change of the velocity.
  constant RAMP_MARGIN_BITS           : positive := 3;
  -- Clock, out of 256, in which the ramp reads its remainder: 15 clocks before the velocity changes in the last clock. The
  -- comparison of the remainder with the braking distances takes 5 of them.
  constant RAMP_LOOK_CLOCK            : positive := 240;

  constant LANES_MAX                  : positive := 64;
  constant LANES_DEFAULT              : positive := 32;

  -- Number of samples in one capture bank: 12,000 samples of a turn at 30 deg/s and 1 kHz, plus a margin.
  constant CAPTURE_DEPTH_DEFAULT      : positive := 12288;

  -- Conditions: the amplitude of a lane is multiplied by a modulator s1.16 of magnitude at most 1. 18 bits are the
  -- width of the B port of the DSP48E1. The sign and the integer bit of the factor 1 take 2 of them; 16 fraction bits
  -- remain.
  constant MODULATOR_WIDTH            : positive := 18;
  constant MODULATOR_FRACTION         : positive := 16;
  -- Clocks in which amplitude_sweep gives all lanes of both banks a new amplitude: 2 * LANES_MAX steps, and 16 steps for
  -- the square of the speed, which it computes from step 128 on.
  constant AMPLITUDE_SWEEP_CLOCKS     : positive := 144;
  -- Format of the width of stop_operator, u20.4 counts. With 4 fraction bits, half a unit is 1/32 count. 20 integer bits
  -- hold every width below 2**20 counts, which is 22.5 degrees at 2**24 counts per turn.
  constant STOP_WIDTH                 : positive := 24;
  constant STOP_FRACTION              : positive := 4;
  -- Bits of the dead zone of stop_operator, whole counts: a dead zone is at most 255 counts.
  constant DEAD_ZONE_WIDTH            : positive := 8;
  -- Largest step of a reading, counts per clock, that stop_operator counts as motion. A decoder makes steps of one count;
  -- a larger step comes from a change of the carrier or a reset.
  constant STOP_STEP_MAX              : positive := 8;
  -- Binary logarithm of the clocks of a window of table_speed: 16,384 clocks. Each end of a window lies within a clock of
  -- its passage, so the relative error of the speed is at most 1 / 16,384 = 6E-5.
  constant SPEED_WINDOW_BITS          : positive := 14;
  -- Limit of |g| in eighths. When the measured speed changes, the lanes of the speed change the corrected angle; g is
  -- this change divided by the change of the travel in a window. These lanes move the angle in which the speed is
  -- measured: speed(n) = true + g * (speed(n - 1) - speed(n - 2)), which diverges for g >= 1 and for g <= -1/2. With
  -- |g| <= 3/8 an error is multiplied by at most 0.61 per window if g > 0, and by 0.83 if g < 0. The rounding of the
  -- speed, one clock per window, grows by at most 1 / (1 - 2 * |g|) = 4: it moves the correction by at most
  -- 4 * |g| = 1.5 counts at one count per clock, and by 0.02 count at the paper's 30 deg/s.
  constant SPEED_FEEDBACK_EIGHTHS     : positive := 3;
  -- Binary logarithm of the clocks after which the speed is 0 if no window has ended: 168 ms at 100 MHz.
  constant SPEED_LONGEST_BITS         : positive := 24;
  -- Travel in counts below which a window of table_speed gives the speed 0: a vibration across one passage moves less.
  constant SPEED_TREMBLE_COUNTS       : positive := 2;
  -- Travel in counts that table_speed reports as a bound while no window ends: without a passage the table moves at most
  -- 4 counts in a window, and the bound comes at the earliest after 2 windows.
  constant SPEED_BOUND_COUNTS         : positive := 8;

  -- Local table: number of windows of the turn that it covers, a power of two: with 1, 2 or 4 windows, the upper bits of
  -- an index select the window.
  constant LOCAL_WINDOWS              : positive := 4;
  -- Bits of the index of a point. 4,096 points of 18 bits in two banks fill 4 block RAMs of 36 Kbit (RAMB36).
  constant LOCAL_INDEX_WIDTH          : positive := 12;
  -- Bits of a point, s(17 - F).F counts with F = 4, 6, 8 or 10: the width of a word of a RAMB36 with its parity bits.
  constant LOCAL_POINT_WIDTH          : positive := 18;
  -- Format of the interpolated value, s13.22 counts: 10 fraction bits of a point plus 12 of the place between two points,
  -- so the interpolation is not rounded; 13 integer bits hold the largest point, 2**17 - 1 with F = 4.
  constant LOCAL_VALUE_WIDTH          : positive := 36;
  constant LOCAL_VALUE_FRACTION       : positive := 22;
  -- Clocks from an angle to its value: 4 to find the window, 5 for the place in it, 3 to read and 5 to interpolate.
  constant LOCAL_TABLE_LATENCY        : positive := 17;

  -- Mean of the heads: number of heads, and number formats of offsets, weights, differences and the mean's term.
  constant HEADS_MAX                  : positive := 4;
  constant HEAD_OFFSET_WIDTH          : positive := 28;
  constant HEAD_OFFSET_FRACTION       : positive := 4;
  constant HEAD_WEIGHT_WIDTH          : positive := 18;
  constant HEAD_WEIGHT_FRACTION       : positive := 16;
  constant HEAD_DIFFERENCE_WIDTH      : positive := 21;
  constant MEAN_TERM_WIDTH            : positive := 40;
  constant MEAN_TERM_FRACTION         : positive := 20;

  -- head_watch: binary logarithm of the clocks between two stored readings, 164 us at 100 MHz. A step is searched over 7 to
  -- 8 such intervals; head_failover counts return_after in units of 8 intervals.
  constant WATCH_INTERVAL_BITS        : positive := 14;
  -- Number of readings that head_watch stores, addressed by 3 bits; a reading is compared with the oldest of them.
  constant WATCH_READINGS             : positive := 8;
  -- Clocks after a restart until head_watch stores readings: more than DIFFERENCE_LATENCY + 1 clocks, so that every
  -- difference comes from readings after the restart.
  constant WATCH_SETTLE_CLOCKS        : positive := 16;
  -- Largest number of counts by which head_watch counts one head as ahead of another: the largest missing_counts, u8.0.
  constant WATCH_AHEAD_MAX            : positive := 255;
  -- Clocks for which head_failover clears the index of a head that is left out: more than INDEX_JUDGED_AFTER, so that
  -- no older index is still being checked when the clearing ends.
  constant FAILOVER_REARM_CLOCKS      : positive := 8;
  -- Value of heads_status.set, u3.0, while the words that the processor wrote are active: no prepared set, 0 to HEADS_MAX,
  -- has this number.
  constant OWN_WORDS_SET              : positive := 7;

  constant TURN_NUMBER_WIDTH          : positive := 24;

  -- Smallest number of counts per turn with REAL_ORDERS: REAL_ORDER_COUNTS_A_LANE for each lane that is built, plus
  -- REAL_ORDER_COUNTS_FURTHER. Then the phase offsets are ready before the next wrap at every speed
  -- (turn_offset_sweep).
  constant REAL_ORDER_COUNTS_A_LANE   : positive := 72;
  constant REAL_ORDER_COUNTS_FURTHER  : positive := 48;

  constant TIMESTAMP_WIDTH            : positive := 64;
  constant CLOCK_HZ                   : positive := 100000000;

end package number_formats_pkg;
