/* SPDX-License-Identifier: Apache-2.0 */

#include "advice.h"

#include <stddef.h>

#include "text.h"

static const struct {
    const char *name;
    const char *text;
} advices[] = {
    {"empty", "the capture holds no sample: rearm"},
    {"index_not_seen", "turn the table past the index of every head and check Z; a head 3 or 4 "
                       "with a fault of A, B or Z gives this reason too"},
    {"index_error", "two index marks were not a turn apart: A or B lost counts, or Z had a false "
                    "pulse; check cables, terminations and index_tolerance"},
    {"illegal_transition", "A and B changed together: crosstalk, a missing termination, or edges "
                           "nearer than filter_length clocks"},
    {"edge_spacing",
     "edges came nearer than minimum_edge_spacing: turn slower; is there crosstalk?"},
    {"bank_full", "the table is so slow that the bank was full before the turn ended: turn faster "
                  "or set a longer sample_period"},
    {"stands_still", "a head does not move: does the table turn, is the head connected?"},
    {"short_of_a_turn", "the table stopped, or counts_per_rev is more than the disc has"},
    {"more_than_a_turn", "sample_period is too long for this speed, or counts_per_rev too small"},
    {"reversal", "the table turned back: nothing is lost, and the next steady turn is used"},
    {"jump",
     "a head moved by more than two steps at once: it lost counts, or the table was pushed"},
    {"wrong_step", "the speed changed by more than a tenth: from now on the turns are sampled at "
                   "equal angles, unless sync_capture is 1"},
    {"over_speed", "the turn has too few samples, or its counts came faster than one a clock: turn "
                   "slower, set a shorter sample_period or fewer orders"},
    {"inconsistent_heads",
     "the heads count in different directions: exchange A and B of one of them"},
    {"heads_exchanged",
     "head 2 is where head 1 should be: exchange the plugs of the two heads, or A "
     "and B of both if they count down counter-clockwise; if neither is wrong, set separation_deg "
     "to 360 minus its value. No turn is used until then"},
    {"heads_elsewhere", "a head is over 0.25 degrees off separation_deg, head3_deg or head4_deg"},
    {"no_mean",
     "with the heads at these places a mean is impossible or noisier than one head: move a head"},
    {"singular", "the fit has no solution: set fewer orders; is separation_deg right?"},
    {"not_converged", "the fit does not end: set fewer orders; is separation_deg right?"},
    {"not_finite", "the fit has no solution: set fewer orders; is separation_deg right?"},
    {"amplitude", "an order's amplitude exceeds a lane's range: is counts_per_rev right?"},
    {"noise", "the turn is much noisier than usual (noise_limit), or its noise is above "
              "alarm_noise_arcsec: look for vibration, an unsteady speed and bad cables"},
    {"not_better", "nothing is wrong: the coefficients in use are as good"},
    {"error", "the correction in use leaves more than alarm_error_arcsec, or the error that "
              "remains at a loaded order exceeds its scatter (load status). The calibration "
              "corrects its own orders unless freeze is on; for a loaded order load a new file"},
    {"separation",
     "the heads are not separation_deg apart, or a head of the mean is not at its "
     "place, within alarm_separation_arcsec: if a head was moved, set separation_deg to "
     "the value in status; else check the index of every head"},
    {"output", "the output stands still (help cannot_keep_up), or its line drivers are released "
               "(help released)"},
    {"core_reset", "the fabric was reset and is set up again: the correction is off until a turn "
                   "is captured anew; the receiver may have lost counts and has to look for its "
                   "zero; check the board's supply and reset"},
    {"swallowed", "edges of head 1 came faster than filter_length lets through, and counts are "
                  "lost: turn slower, or set a "
                  "shorter filter_length; make the servo safe, then clear_output, and let the "
                  "receiver look for its zero"},
    {"released",
     "the line drivers were switched off by a fault of release_sources: end the faults that are "
     "still present (clear_output clears the flags of heads and swallowed; forget or bypass on "
     "ends correction_limited), make the servo safe, then clear_output"},
    {"cannot_keep_up",
     "the output stands still: it fell further behind than following_limit, so its receiver lost "
     "counts; turn slower or set a shorter output_spacing, make the servo safe, then clear_output, "
     "and let the receiver look for its zero"},
    {"overrun",
     "turns came faster than they are processed, and some were left out; nothing else is lost"},
    {"stuck_capture", "in four turns no capture was completed: the correction is off and the "
                      "capture was begun anew; check sample_period"},
    {"coefficients", "the gateware does not hold the written words: do not use this board"},
    {"temperature", "the die is hotter than alarm_temperature_c: cool the board"},
    {"thermometer", "the table's temperature is held at its last good value: status shows why; the "
                    "loaded lanes that follow it stay as they are"},
    {"silent", "the thermometer does not answer: check its cable; meanwhile the host can set the "
               "temperature with temperature VALUE"},
    {"jumped", "the temperature changed faster than a table can (temperature_jump_k): check the "
               "thermometer, then enter temperature sensor"},
    {"unchanged", "the temperature has not changed for temperature_still_s: check the thermometer "
                  "or the host; if the table is that steady, set temperature_still_s longer"},
    {"not_copied",
     "the turn has no or too many samples, or a step does not fit into the copy: use more samples "
     "a turn, or at most 6,144 (3,072 with more than two heads); dump again"},
    {"swap", "the core did not take new coefficients: the correction is off and the calibration "
             "starts anew; if this happens again, do not use this board"},
    {"wrong_crc", "the frame was changed in transit, or is no frame: send it again"},
    {"wrong_frame", "another frame was expected: begin the load anew"},
    {"too_many_lanes", "more orders than the gateware has lanes: export fewer with --lanes"},
    {"out_of_range", "an order, phase or amplitude exceeds a lane's range, maybe at a "
                     "temperature of the file's range: is the file whole?"},
    {"order_twice", "two lanes of the file have the same order: write the file anew"},
    {"not_whole", "frames are missing, or the gateware no longer holds the points of the loaded "
                  "table: load the file anew"},
    {"another_table", "the coefficients were made for another counts_per_rev than is set here"},
    {"too_steep",
     "with these coefficients the corrected angle could turn back: |d error/d angle| is "
     "1 or more, at some temperature of the file's range"},
    {"worse_prediction",
     "the captured turn contradicts the set; load status names the order that differs, if a "
     "single order does; is the file from this table, and is the index unchanged?"},
    {"other_heads",
     "the set's mean has another number of heads than this core, or a head is not where its offset "
     "states: capture and calibrate again; was a head moved?"},
    {"other_delays",
     "the set was made with other delays: set head_delays as the set states, then capture anew"},
    {"unseen_order",
     "two heads at this angle cannot see one of the orders, so no turn can judge it: "
     "leave it out, or arctrue load --unseen"},
    {"no_modulators",
     "a lane follows direction, speed or a word, and this gateware is built without MODULATORS: "
     "export without --modulators, or build it with MODULATORS=true"},
    {"unstable_speed",
     "the lanes that follow the speed move the corrected angle by more than 3/8 of the travel in "
     "2^14 "
     "clocks at the nominal speed, so the measured speed would oscillate: leave them out"},
    {"no_failover",
     "the file has sets for a missing head, and this gateware is built without FAILOVER: export "
     "without them, or build it with FAILOVER=true"},
    {"head_left_out",
     "a head failed, and the gateware goes on without it: status and telemetry name it and the "
     "causes; look at its cable and supply, then come_back HEAD and turn past its index"},
    {"no_set", "a head failed and is still in the mean, because there is no valid set without it: "
               "look at its cable and supply, then load a file with sets or rearm"},
    {"failover_off",
     "frames of a load have replaced the sets for a missing head: no failover until a loaded set "
     "is active; if no load is under way, load the file again"},
    {"no_real_orders", "a lane has an order that is not whole, and this gateware is built without "
                       "REAL_ORDERS: export "
                       "without --real-orders, or build it with REAL_ORDERS=true"},
    {"no_local_table", "the set has a local table, and this gateware is built without "
                       "LOCAL_TABLE: load another bitstream, or export without --local-table"},
    {"too_few_counts", "a lane of a real order needs 72 counts a turn for each lane of the "
                       "gateware, and 48 more: leave "
                       "it out, or build fewer lanes"},
    {"not_read_back", "the gateware does not hold the written words: do not use this board"},
    {"lost", "a fault has cleared the settings: the parameters are as they were saved, or "
             "preset, and the switches are preset; set those that differ, then bypass off"},
    {"held", "the third fault in a row, or the settings are lost: the core goes on with its "
             "coefficients, and no turn is processed; note reset and reset_instruction, "
             "then rearm, which takes the correction off until the next index"},
    {"began_anew", "the processor had a fault and began anew; the correction went on with the last "
                   "coefficients; note reset and reset_instruction"},
    {"not_confirmed",
     "the captured turn contradicts the saved coefficients, or they do not fit this core: they are "
     "not used; was a head or the disc moved? rearm tries them again, save replaces them"},
    {"flash_unknown", "no flash, or an unknown flash, answers: nothing is saved"},
    {"under_way", "a save or a flash command has not ended yet: wait for its answer"},
    {"flash_silent", "the flash's controller does not answer: nothing is saved"},
    {"flash_stuck", "an operation of the flash does not end: the saved data stays"},
    {"flash_not_erased", "the flash was not erased; is it protected? The saved data stays"},
    {"flash_not_read_back", "the flash does not hold the written data; is it protected? "
                            "The saved data stays; save "
                            "again"},
    {"unread", "the flash did not answer at the start: the saved data is not in use; start again"},
    {"not_read_at_start",
     "the flash did not answer at the start: the saved data is not in use; start again "
     "to use it, or save again to replace it"},
    {"fewer_orders",
     "the record holds more orders than would be saved now: let the table turn until "
     "they are active, or forget first to remove them"},
    {"table_not_held",
     "the gateware lost the points of the loaded local table, maybe to a load that was aborted: "
     "load the table again, then save; or forget first"},
    {"golden_stays",
     "a complete golden image is not overwritten: it starts if the first image is not whole"},
    {"zero_lost", "a head lost counts: the zero of head 1 is moved to its index or searched again, "
                  "and the counts of head 2 are corrected; check cables and terminations"},
};

const char *advice_for(const char *name) {
    for (size_t place = 0; place < sizeof advices / sizeof advices[0]; place++) {
        if (text_equal(advices[place].name, name)) {
            return advices[place].text;
        }
    }
    return NULL;
}
