/* SPDX-License-Identifier: Apache-2.0 */

/* Declares the state of the application, and the functions with which several files read it. */

#ifndef ARCTRUE_STATE_H
#define ARCTRUE_STATE_H

#include "average.h"
#include "capture_copy.h"
#include "core.h"
#include "fourier.h"
#include "further_orders.h"
#include "gate.h"
#include "head_skew.h"
#include "heads_fit.h"
#include "kept_settings.h"
#include "least_squares.h"
#include "load.h"
#include "parameters.h"
#include "reading_function.h"
#include "save.h"
#include "table_temperature.h"

enum application_phase {
    PHASE_NO_CORE,
    PHASE_WAIT_FOR_INDEX,
    PHASE_CAPTURE,
    PHASE_SWAP,
    /* Held after several faults in a row, or because the settings are lost while a correction is active: the core
       continues with its coefficients, and nothing is calibrated. */
    PHASE_HELD,
};

/* Origin of the operator's settings. */
enum settings_origin {
    SETTINGS_PRESET,
    /* After a fault: the settings that the operator had ordered before the fault. */
    SETTINGS_KEPT,
    /* After a fault that destroyed the settings in memory: the saved parameters or presets, preset switches, and bypass
       on if no correction is active. */
    SETTINGS_LOST,
    /* At power-on: the saved settings. */
    SETTINGS_SAVED,
};

/* State of the saved coefficients. */
enum saved_state {
    SAVED_NONE,
    /* No captured turn has confirmed the saved coefficients yet. */
    SAVED_WAITING,
    SAVED_CONFIRMED,
    /* A turn contradicts the saved coefficients, or they do not fit this core: they wait for the next `rearm`. */
    SAVED_NOT_CONFIRMED,
};

/* State of a dump, the copy of a capture for the console: none, requested, copied, or impossible to copy. */
enum dump_state { DUMP_NONE, DUMP_WANTED, DUMP_COPIED, DUMP_NOT_COPIED };

/* Origin of the candidate: this turn's calibration, the received set, the set that was loaded before the start, or the
   saved coefficients. */
enum candidate_origin { OF_TURN, OF_LOAD, OF_PENDING, OF_SAVED };

enum turn_result { TURN_APPLIED, TURN_KEPT, TURN_REFUSED };

enum alarm {
    ALARM_NOISE = 1,
    ALARM_ERROR = 2,
    ALARM_SEPARATION = 4,
    ALARM_OUTPUT = 8,
    ALARM_OVERRUN = 16,
    ALARM_STUCK_CAPTURE = 32,
    ALARM_COEFFICIENTS = 64,
    ALARM_TEMPERATURE = 128,
    ALARM_ZERO_LOST = 256,
    ALARM_SWAP = 512,
    /* The firmware recently restarted after a fault. */
    ALARM_BEGAN_ANEW = 1024,
    ALARM_SAVED = 2048,
    ALARM_THERMOMETER = 4096,
    ALARM_CORE_RESET = 8192,
    /* The gateware has left a head out of the mean. */
    ALARM_HEAD_LEFT_OUT = 16384,
    /* A load has overwritten the sets for a missing head that belong to the active mean. */
    ALARM_FAILOVER_OFF = 32768,
    /* A head has failed, and the gateware has no valid set without it. */
    ALARM_NO_SET = 65536,
};

/* Prepared sets in the gateware that belong to the active mean of the heads. Such a set contains the coefficients that
   apply while one head (the missing head) is left out of the mean. */
struct prepared {
    /* Missing heads for which there is a set, one bit per head; 0: the failover stays off. */
    uint32_t sets;
    /* True if frames of a load have overwritten the sets of the active mean. */
    bool overwritten;
    /* Check sums of the words as the firmware wrote them, see core_prepared_sum(): `sum` of the sets for a missing
       head, `sum_of_all_heads` of set 0, which has all heads. */
    uint32_t sum;
    uint32_t sum_of_all_heads;
    /* Left-out heads that were reported to the operator. */
    uint32_t reported;
    /* True if the gateware has refused a set. */
    bool refused;
    /* `has_made`: the workspace holds sets for a missing head that belong to the candidate. `made`: the missing heads
       of these sets, one bit per head. */
    bool has_made;
    uint32_t made;
};

/* The latest turn, for the console and for telemetry. */
struct turn_report {
    uint32_t number;
    uint32_t sequence_number;
    uint64_t start_time;
    uint32_t samples;
    enum turn_result result;
    enum refusal reason;
    struct capture_fault fault;
    struct gate_prediction prediction;
    /* Remaining error at the loaded orders; both predictions include it. */
    double loaded_arcsec;
    /* Measurements of lanes that follow a condition. The lanes belong to the set that the turn judges or, without such
       a set, to the loaded set. */
    struct followed_measured followed[FOLLOWED_LANES_MAX];
    uint32_t followed_lanes;
    /* Largest difference between the measured angle of a head and its angle according to the offsets of the judged or
       active mean; negative if it was not measured. */
    double mean_off_arcsec;
    /* Head that has moved since the active offsets were set, from 1 on, and its motion along the scale; 0: none. */
    uint32_t moved_head;
    double moved_arcsec;
    /* Reason why the turn did not calibrate the mean, if the device is to calibrate it. */
    enum refusal mean_reason;
    uint32_t alarms;
    /* True if A, B and Z stand still, because the output fell too far behind. */
    bool output_stands;
    /* Faults that released (switched off) the line drivers of the output, bits of enum core_fault. */
    uint32_t release_causes;
    /* Temperature of the die; the value counts only if has_temperature is true. */
    bool has_temperature;
    double temperature_c;
    /* True if the report has not been printed yet. */
    bool fresh;
    /* True if the turn has been printed already and only an alarm is new. */
    bool between_turns;
};

union calibration_workspace {
    struct fourier_workspace fourier;
    struct least_squares_workspace least_squares;
    struct heads_workspace heads;
    struct reading_workspace reading;
    struct further_workspace further;
};

/* Makes data that was written to memory survive a restart. */
typedef void memory_settle(void);

struct application {
    struct core_access core;
    /* Reads the temperature of the die; NULL if there is no sensor. */
    temperature_read *read_temperature;
    void *temperature_context;
    struct core_configuration configuration;
    struct parameters parameters;
    enum application_phase phase;
    /* Switches of the operator. */
    bool frozen;
    bool bypassed;
    bool telemetry;
    /* Memory of the settings; NULL if the settings are not kept. */
    struct kept_settings *kept;
    memory_settle *settle;
    enum settings_origin settings_origin;
    uint32_t faults_in_a_row;
    /* True if the release of the line drivers has been reported. */
    bool release_reported;
    /* Header and capture of the bank that is ready. */
    struct core_header header;
    struct capture capture;
    enum dump_state dump;
    /* Memory for a copied capture; NULL if no capture is copied. */
    struct capture_copy *copy;
    int32_t position_at_bank;
    /* Angle of head 2 at its own index, counts; not 0 once head 2 has lost counts since the index that defined its
       zero. For head 1 the core moves the zero instead; zero_moves is the number of these moves. */
    int32_t head2_zero;
    uint32_t zero_moves;
    /* `zero_in_doubt`: true while the angle of head 1 at its index differs from 0 without proof of a loss of counts;
       `position_at_doubt`: position of head 1 when this state began. */
    bool zero_in_doubt;
    int32_t position_at_doubt;
    uint32_t swaps_before;
    uint32_t swap_looks;
    /* `measured`: estimate of the latest turn, even if it was refused; `estimate`: estimate of the latest accepted
       turn. */
    struct estimate measured;
    struct estimate estimate;
    /* Results of the latest turn that calibrated the mean of three or four heads; `heads` of its geometry is 0 if the
       latest turn calibrated no mean or its results were discarded. */
    struct heads_found found;
    /* Memory for the motion of the axis that repeats; NULL: the motion that does not repeat is not measured. */
    struct axis_mean *axis;
    /* Delays of the heads, from the latest two turns at different speeds. */
    struct head_skew skew;
    struct average average;
    enum verdict verdicts[ORDERS_MAX];
    struct coefficients active;
    struct coefficients candidate;
    struct load load;
    struct table_temperature table;
    struct prepared prepared;
    /* Temperature of the table after the previous turn was processed, and the time at that moment (0: the temperature
       was not known). `middle_celsius`: temperature in the middle of this turn or, if no earlier temperature is known,
       the present temperature of `table`. */
    double before_celsius;
    double before_s;
    double middle_celsius;
    /* True if the speed varies too much: samples are taken at equal angles until the next start or dump. */
    bool by_angle;
    /* Clock rate of the core's time for the thermometer; 0: the rate that the core states. In the virtual instrument a
       second has fewer clocks. */
    double temperature_clock_hz;
    /* Number of coefficient banks that were activated between two turns because the table's temperature had changed. */
    uint32_t temperature_swaps;
    /* Storage in the flash; NULL if there is no flash. */
    struct save *save;
    enum saved_state saved_state;
    enum candidate_origin candidate_origin;
    /* True if the gateware applies `active`. Otherwise `active` holds the coefficients that were active before the core
       restarted. */
    bool has_active;
    /* True if the operator has ordered the firmware to discard all results. */
    bool forgotten;
    /* True if a correction from before a fault is still active; the firmware does not know its coefficients. */
    bool inherited;
    double usual_noise_arcsec;
    uint32_t noisy_turns;
    /* Statistics. */
    struct turn_report report;
    uint32_t refusals[REFUSALS];
    uint32_t turns;
    uint32_t swaps;
    uint32_t stuck_captures;
    uint32_t overruns;
    /* `interrupts`: number of interrupts of the core; `banks_without_interrupt`: number of banks that the firmware
       found ready without an interrupt since the previous bank. */
    uint32_t interrupts;
    uint32_t banks_without_interrupt;
    bool interrupted;
    union calibration_workspace workspace;
};

const char *output_fault_name(bool stands);
const char *application_phase_name(enum application_phase phase);
const char *settings_origin_name(enum settings_origin origin);
const char *saved_state_name(enum saved_state state);
const char *turn_result_name(enum turn_result result);

/* Returns `thermal` if the table's temperature is known; otherwise NULL, and lanes that follow the temperature stay as
   written. */
const struct thermal *application_thermal(const struct application *application,
                                          const struct thermal *thermal);

/* Tells whether operator and coefficients allow the correction. */
bool application_corrects(const struct application *application);

/* Returns how the core is to sample: at the edges of sync_in, at equal angles, or at equal times. */
enum core_capture application_capture(const struct application *application);

/* Asserts the conditions that hold between any two calls. */
void state_assert(const struct application *application);

/* Tells whether there is a core and the firmware uses it. */
bool state_works(const struct application *application);

/* Returns the time of the core's own clock, s; 0 if its rate is not known. */
double state_seconds(const struct application *application);

/* Discards the running averages over former turns, and the latest turn's results for the heads. */
void state_forget_turns(struct application *application);

/* Returns the active coefficients, NULL if there are none. */
const struct coefficients *state_active(const struct application *application);

#endif
