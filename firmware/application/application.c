/* SPDX-License-Identifier: Apache-2.0 */

#include "application.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

#include "calibrate.h"
#include "units.h"

/* Turns of head 1 without a bank after which the capture is stuck. */
enum { STUCK_TURNS = 4 };
/* Of a bank: the samples that close a turn. */
enum { SPARE_SAMPLES = 4 };
/* A swap is over within some hundred clocks of the core; a look at its counter takes at least one
   access of its bus. */
enum { SWAP_LOOKS_MOST = 1000 };
/* Two marks that agree come within two turns. After so many without, head 1 loses counts in every
   turn or has no index any more. */
enum { DOUBT_TURNS = 4 };
/* More than this head 1 does not lose from one index to the next without another fault. */
#define LOST_TURNS_MOST (1.0 / 1024.0)
/* Those that end with the flags of a head. */
enum { HEAD_FAULTS = CORE_FAULT_HEAD1 | CORE_FAULT_HEAD2 | CORE_FAULT_SWALLOWED };
/* So many faults in a row are no accident; so many turns later there was none in a row. */
enum { FAULTS_HELD = 3, FAULT_FORGOTTEN_TURNS = 20 };

const char *application_phase_name(enum application_phase phase) {
    static const char *const names[] = {"no_core", "wait_for_index", "capture", "swap",
                                        "held"};
    return (unsigned)phase <= PHASE_HELD ? names[phase] : "unknown";
}

const char *settings_origin_name(enum settings_origin origin) {
    static const char *const names[] = {"preset", "kept", "lost", "saved"};
    return (unsigned)origin <= SETTINGS_SAVED ? names[origin] : "unknown";
}

const char *saved_state_name(enum saved_state state) {
    static const char *const names[] = {"none", "waiting", "confirmed", "not_confirmed"};
    return (unsigned)state <= SAVED_NOT_CONFIRMED ? names[state] : "unknown";
}

const char *output_fault_name(bool stands) {
    return stands ? "cannot_keep_up" : "none";
}

const char *turn_result_name(enum turn_result result) {
    static const char *const names[] = {"applied", "kept", "refused"};
    return (unsigned)result <= TURN_REFUSED ? names[result] : "unknown";
}

const char *alarm_name(uint32_t bit) {
    switch (bit) {
    case ALARM_NOISE:
        return "noise";
    case ALARM_ERROR:
        return "error";
    case ALARM_SEPARATION:
        return "separation";
    case ALARM_OUTPUT:
        return "output";
    case ALARM_OVERRUN:
        return "overrun";
    case ALARM_STUCK_CAPTURE:
        return "stuck_capture";
    case ALARM_COEFFICIENTS:
        return "coefficients";
    case ALARM_TEMPERATURE:
        return "temperature";
    case ALARM_ZERO_LOST:
        return "zero_lost";
    case ALARM_SWAP:
        return "swap";
    case ALARM_BEGAN_ANEW:
        return "began_anew";
    case ALARM_SAVED:
        return "not_confirmed";
    case ALARM_THERMOMETER:
        return "thermometer";
    case ALARM_CORE_RESET:
        return "core_reset";
    default:
        return NULL;
    }
}

void application_prepare(struct application *application, const struct core_access *core) {
    memset(application, 0, sizeof *application);
    application->core = *core;
    application->phase = PHASE_NO_CORE;
    parameters_preset(&application->parameters);
}

void application_use_temperature(struct application *application, temperature_read *read,
                                 void *context) {
    application->read_temperature = read;
    application->temperature_context = context;
}

void application_use_thermometer(struct application *application, temperature_read *read,
                                 void *context) {
    table_temperature_use(&application->table, read, context);
}

/* The core's own clock. */
static double seconds(const struct application *application) {
    double clock_hz = application->temperature_clock_hz > 0.0
                          ? application->temperature_clock_hz
                          : application->configuration.clock_hz;
    return clock_hz > 0.0 ? (double)core_position(&application->core).time / clock_hz : 0.0;
}

void application_tell_temperature(struct application *application, double celsius) {
    table_temperature_tell(&application->table, celsius, seconds(application));
}

void application_choose_temperature(struct application *application,
                                    enum temperature_source source) {
    table_temperature_choose(&application->table, source);
}

const struct thermal *application_thermal(const struct application *application,
                                          const struct thermal *thermal) {
    return table_temperature_is_known(&application->table) ? thermal : NULL;
}

void application_keep_settings(struct application *application, struct kept_settings *kept,
                               memory_settle *settle) {
    application->kept = kept;
    application->settle = settle;
}

void application_use_copy(struct application *application, struct capture_copy *copy) {
    application->copy = copy;
}

void application_use_flash(struct application *application, struct save *save) {
    application->save = save;
}

static struct settings present_settings(const struct application *application) {
    return (struct settings){
        .parameters = application->parameters,
        .frozen = application->frozen,
        .bypassed = application->bypassed,
        .telemetry = application->telemetry,
        .faults_in_a_row = application->faults_in_a_row,
    };
}

/* Before an order is carried out: a fault in between then begins anew with the order. */
static void keep_settings(struct application *application) {
    struct settings settings = present_settings(application);
    if (application->kept != NULL) {
        kept_settings_write(application->kept, &settings);
        application->settle();
    }
}

static void take_settings(struct application *application, const struct settings *settings) {
    application->parameters = settings->parameters;
    application->frozen = settings->frozen != 0;
    application->bypassed = settings->bypassed != 0;
    application->telemetry = settings->telemetry != 0;
}

/* Where they are lost nobody knows whether the correction may be switched on. */
static void recover_settings(struct application *application) {
    struct settings settings;
    if (application->kept == NULL || !kept_settings_read(application->kept, &settings)) {
        application->settings_origin = SETTINGS_LOST;
        application->bypassed = true;
        application->faults_in_a_row = 1;
        return;
    }
    application->settings_origin = SETTINGS_KEPT;
    take_settings(application, &settings);
    application->faults_in_a_row = settings.faults_in_a_row + 1;
}

/* The coefficients have to wait for a turn that confirms them. */
static void recover_saved(struct application *application) {
    if (application->save == NULL || !save_find(application->save)) {
        return;
    }
    const struct saved *saved = &application->save->content;
    application->saved_state = saved_lanes(saved) > 0 ? SAVED_WAITING : SAVED_NONE;
    if (application->settings_origin == SETTINGS_PRESET) {
        application->settings_origin = SETTINGS_SAVED;
        take_settings(application, &saved->settings);
    } else if (application->settings_origin == SETTINGS_LOST) {
        application->parameters = saved->settings.parameters;
    }
}

/* The registers' units: 2^-35 count a clock, and 2^-59 count a clock and clock. */
#define RATE_UNIT 0x1p35
#define ACCELERATION_UNIT 0x1p59

static uint32_t register_of(double value) {
    return value < (double)UINT32_MAX ? (uint32_t)(value + 0.5) : UINT32_MAX;
}

/* Of samples at equal angles: one that divides the turn, so that all gaps are alike, where there is
   one that leaves a bank at least half full. */
static uint32_t angle_step(uint32_t counts_per_rev, uint32_t depth) {
    uint32_t most = depth > 2 * SPARE_SAMPLES ? depth - SPARE_SAMPLES : SPARE_SAMPLES;
    uint32_t least = counts_per_rev / most + 1;
    for (uint32_t step = least; step < 2 * least; step++) {
        if (counts_per_rev % step == 0) {
            return step;
        }
    }
    return least;
}

/* The same angle a second whatever the counts of a turn are. */
static struct core_setup setup_of(const struct application *application) {
    const struct parameters *parameters = &application->parameters;
    double clock_hz = application->configuration.clock_hz;
    double counts_an_arcsec = parameters->counts_per_rev / ARCSEC_PER_TURN;
    double counts_a_clock = parameters->ramp_arcsec_s * counts_an_arcsec / clock_hz;
    double counts_a_clock_2 =
        parameters->ramp_arcsec_s2 * counts_an_arcsec / (clock_hz * clock_hz);
    return (struct core_setup){
        .counts_per_rev = (uint32_t)parameters->counts_per_rev,
        .sample_period = (uint32_t)parameters->sample_period,
        .angle_step = angle_step((uint32_t)parameters->counts_per_rev,
                                 application->configuration.capture_depth),
        .ramp_rate = register_of(counts_a_clock * RATE_UNIT),
        .ramp_acceleration = register_of(counts_a_clock_2 * ACCELERATION_UNIT),
        .output_spacing = (uint32_t)parameters->output_spacing,
        .filter_length = (uint32_t)parameters->filter_length,
        .minimum_edge_spacing = (uint32_t)parameters->minimum_edge_spacing,
        .index_tolerance = (uint32_t)parameters->index_tolerance,
        .heal = parameters->heal != 0.0,
        .head1_input = (uint32_t)parameters->head1_input,
        .head2_input = (uint32_t)parameters->head2_input,
        .output_pins = (uint32_t)parameters->output_pins,
        .alarm = (uint32_t)parameters->release_sources << 8 |
                 (uint32_t)parameters->alarm_sources,
        .pulse_widths = (uint32_t)parameters->compare_width << 16 |
                        (uint32_t)parameters->trigger_width,
        .pulse_inputs = (uint32_t)parameters->pulse_filter << 8 |
                        (uint32_t)parameters->probe_falling << 1 |
                        (uint32_t)parameters->sync_falling,
    };
}

/* There is a core, and it is worked with. */
static bool works(const struct application *application) {
    return application->phase != PHASE_NO_CORE && application->phase != PHASE_HELD;
}

/* The correction is on only with coefficients of our own, or with those that it had before a fault: the
   banks survive a reset of the core. */
bool application_corrects(const struct application *application) {
    return (application->has_active || application->inherited) && !application->bypassed;
}

enum core_capture application_capture(const struct application *application) {
    if (application->parameters.sync_capture != 0.0) {
        return CAPTURE_BY_SYNC;
    }
    return application->by_angle ? CAPTURE_BY_ANGLE : CAPTURE_BY_TIME;
}

static void set_control(const struct application *application) {
    core_control(&application->core, application_corrects(application), true,
                 application_capture(application));
}

/* From what the core had seen before the re-arm nothing can be used. */
static void give_back_old_bank(const struct application *application) {
    if (core_status(&application->core).capture_ready) {
        core_release_capture(&application->core);
    }
}

/* What was loaded is judged anew; it need not come again. */
static void begin_with_nothing(struct application *application) {
    load_again(&application->load, (uint32_t)application->parameters.counts_per_rev);
    application->has_active = false;
    application->inherited = false;
    application->usual_noise_arcsec = 0.0;
    application->noisy_turns = 0;
    average_clear(&application->average);
    if (works(application)) {
        set_control(application);
    }
}

void application_forget(struct application *application) {
    load_forget(&application->load);
    application->active = (struct coefficients){0};
    application->forgotten = true;
    application->saved_state = SAVED_NONE;
    begin_with_nothing(application);
}

/* The angle of a head at its last index where it is not the one that is known, within the
   repeatability of the index; `known` otherwise. */
static int32_t zero_of(const struct application *application, uint32_t head, int32_t known) {
    uint32_t turn = (uint32_t)application->parameters.counts_per_rev;
    double tolerance = application->parameters.index_tolerance;
    int32_t angle = core_angle_at_index(&application->core, head, turn);
    if (fabs((double)angle) <= tolerance) {
        return 0;
    }
    return fabs((double)angle - known) > tolerance ? angle : known;
}

/* Both are made anew by the next index of each head. */
static void forget_zeros(struct application *application) {
    application->position_at_bank = core_position(&application->core).head1_position;
    application->head2_zero = 0;
    application->zero_moves = core_zero_moves(&application->core);
    application->zero_in_doubt = false;
}

void application_start(struct application *application) {
    application->phase = PHASE_NO_CORE;
    application->by_angle = false;
    begin_with_nothing(application);
    if (application->saved_state == SAVED_NOT_CONFIRMED) {
        application->saved_state = SAVED_WAITING;
    }
    if (!core_identify(&application->core, &application->configuration)) {
        return;
    }
    struct core_setup setup = setup_of(application);
    if (!core_set_up(&application->core, &setup)) {
        return;
    }
    core_disarm_compare(&application->core);
    forget_zeros(application);
    give_back_old_bank(application);
    application->overruns = core_overrun_count(&application->core);
    application->phase = PHASE_WAIT_FOR_INDEX;
    set_control(application);
}

/* The core stays as the fault has left it. */
static void hold(struct application *application) {
    application->phase = PHASE_NO_CORE;
    if (core_identify(&application->core, &application->configuration)) {
        application->inherited = core_compensates(&application->core);
        application->phase = PHASE_HELD;
    }
}

/* After a fault the core is at work: index, coefficients and correction stay. False: it is not the
   core of before. */
static bool resume(struct application *application) {
    const struct core_access *core = &application->core;
    if (!core_identify(core, &application->configuration)) {
        return false;
    }
    struct core_setup setup = setup_of(application);
    if (!core_resume(core, &setup)) {
        return false;
    }
    begin_with_nothing(application);
    application->inherited = core_compensates(core);
    forget_zeros(application);
    if (core_indices_seen(core)) {
        application->head2_zero = zero_of(application, 1, 0);
    }
    give_back_old_bank(application);
    application->overruns = core_overrun_count(core);
    application->phase = PHASE_WAIT_FOR_INDEX;
    set_control(application);
    return true;
}

void application_recover(struct application *application, bool after_fault) {
    if (after_fault) {
        recover_settings(application);
    }
    recover_saved(application);
    keep_settings(application);
}

/* Settings that are lost are no reason to take a correction off that is at work. */
static bool must_not_touch(struct application *application) {
    if (application->settings_origin != SETTINGS_LOST ||
        !core_identify(&application->core, &application->configuration) ||
        !core_compensates(&application->core)) {
        return false;
    }
    application->bypassed = false;
    return true;
}

void application_begin(struct application *application) {
    if (application->faults_in_a_row >= FAULTS_HELD || must_not_touch(application)) {
        hold(application);
    } else if (application->settings_origin != SETTINGS_KEPT || !resume(application)) {
        application_start(application);
    }
}

void application_rearm(struct application *application) {
    application->faults_in_a_row = 0;
    keep_settings(application);
    application_start(application);
}

/* The angle is that after the index: before it nothing is armed. */
static void arm_compare(const struct application *application) {
    const struct parameters *parameters = &application->parameters;
    if (parameters->compare_on == 0.0) {
        core_disarm_compare(&application->core);
    } else if (application->phase != PHASE_WAIT_FOR_INDEX) {
        const struct core_places places = {
            .first = (uint32_t)parameters->compare_first,
            .interval = (uint32_t)parameters->compare_interval,
            .counts_per_rev = (uint32_t)parameters->counts_per_rev,
        };
        int32_t position = core_position(&application->core).head1_position;
        core_arm_compare(&application->core, &places,
                         counts_apart(position, application->position_at_bank) >= 0);
    }
}

/* What has been captured of the turn has another zero, or other steps. */
static void capture_anew(const struct application *application) {
    core_control(&application->core, application_corrects(application), true, CAPTURE_OFF);
    set_control(application);
}

static void change_pins(const struct application *application, enum parameter_effect effect) {
    struct core_setup setup = setup_of(application);
    core_set_pins(&application->core, &setup);
    if (effect == EFFECT_CAPTURE) {
        capture_anew(application);
    } else if (effect == EFFECT_COMPARE) {
        arm_compare(application);
    }
}

enum parameter_answer application_set(struct application *application, const char *name,
                                      double value,
                                      const struct parameter_description **description) {
    enum parameter_answer answer =
        parameters_set(&application->parameters, name, value, description);
    if (answer != PARAMETER_SET) {
        return answer;
    }
    if ((*description)->effect == EFFECT_REARM) {
        application_rearm(application);
        return answer;
    }
    keep_settings(application);
    if ((*description)->effect == EFFECT_NEXT_TURN) {
        average_clear(&application->average);
    } else if (works(application)) {
        change_pins(application, (*description)->effect);
    }
    return answer;
}

enum load_answer application_load_end(struct application *application, uint32_t crc) {
    const struct coefficients *active = application->has_active ? &application->active : NULL;
    return load_end(&application->load, (uint32_t)application->parameters.counts_per_rev, active,
                    crc);
}

/* The calibration's lanes of what is at work or was before the core began anew, and what is loaded,
   also while a turn has yet to judge it again. */
static void save_known(const struct application *application, struct saved *saved) {
    const struct load *load = &application->load;
    bool waits = application->saved_state == SAVED_WAITING;
    if (!waits || load_at_work(load) != NULL) {
        bool kept = load->loaded_state != LOADED_REJECTED;
        saved->loaded = kept ? load->loaded : (struct coefficients){0};
        saved->thermal = kept ? load->thermal : (struct thermal){0};
        saved->unjudged = kept ? load->unjudged : 0;
    }
    saved->own = application->active;
    for (uint32_t lane = 0; lane < saved->own.lanes; lane++) {
        if (coefficients_have(&saved->loaded, saved->own.lane[lane].order) ||
            coefficients_have(&load->loaded, saved->own.lane[lane].order)) {
            saved->own.lane[lane] = (struct lane){0};
        }
    }
}

/* What waits for its first turn is saved again, unless it is of another table; what a turn speaks
   against is replaced as soon as there is something else. Whatever is not at work for a moment,
   because the index is looked for again, is kept. */
enum save_answer application_save(struct application *application) {
    struct save *save = application->save;
    if (save == NULL) {
        return SAVE_NO_FLASH;
    }
    if (save->state != SAVE_IDLE) {
        return SAVE_UNDER_WAY;
    }
    enum save_answer readable = save_look_again(save);
    if (readable != SAVE_DONE) {
        return readable;
    }
    struct saved *saved = &save->content;
    uint32_t counts_per_rev = (uint32_t)application->parameters.counts_per_rev;
    bool of_this_table = saved->own.counts_per_rev == counts_per_rev && !application->forgotten;
    bool known = application->active.counts_per_rev == counts_per_rev &&
                 coefficients_most_order(&application->active) != 0;
    saved->settings = present_settings(application);
    if (!of_this_table) {
        *saved = (struct saved){.settings = saved->settings};
    }
    if (known) {
        save_known(application, saved);
    }
    saved->own.counts_per_rev = counts_per_rev;
    saved->loaded.counts_per_rev = counts_per_rev;
    bool asked = application->forgotten || application->has_active ||
                 save->kept_counts_per_rev != counts_per_rev;
    enum save_answer answer = save_begin(save, asked ? 0 : save->kept_lanes);
    if (answer == SAVE_DONE && (known || application->forgotten) &&
        application->saved_state != SAVED_WAITING) {
        application->saved_state = SAVED_NONE;
    }
    return answer;
}

void application_freeze(struct application *application, bool frozen) {
    application->frozen = frozen;
    keep_settings(application);
}

void application_telemetry(struct application *application, bool on) {
    application->telemetry = on;
    keep_settings(application);
}

void application_bypass(struct application *application, bool bypassed) {
    application->bypassed = bypassed;
    keep_settings(application);
    if (works(application)) {
        set_control(application);
    } else if (application->phase == PHASE_HELD && bypassed) {
        /* On again by a re-arm alone. */
        application->inherited = false;
        core_hold(&application->core);
    }
}

const char *application_output_fault(const struct application *application) {
    bool there = application->phase != PHASE_NO_CORE;
    return output_fault_name(there && core_status(&application->core).cannot_keep_up);
}

uint32_t application_release_causes(const struct application *application) {
    bool there = application->phase != PHASE_NO_CORE;
    return there ? core_status(&application->core).release_causes : 0U;
}

uint32_t application_release_present(const struct application *application) {
    bool there = application->phase != PHASE_NO_CORE;
    return there ? core_status(&application->core).release_present : 0U;
}

static void wait_for_index(struct application *application) {
    if (core_indices_seen(&application->core)) {
        application->phase = PHASE_CAPTURE;
        /* After a fault of the firmware it goes on where it was. */
        if (!core_status(&application->core).compare_armed) {
            arm_compare(application);
        }
        application->position_at_bank = core_position(&application->core).head1_position;
    }
}

/* With the turn that is told next, or else in a line of its own. */
static void tell_between_turns(struct application *application, uint32_t alarm) {
    struct turn_report *report = &application->report;
    report->alarms |= alarm;
    report->between_turns = report->between_turns || !report->fresh;
    report->fresh = true;
}

/* Safe state: the correction decays to nothing; the capture starts anew. */
static void capture_is_stuck(struct application *application, int32_t position) {
    application->stuck_captures++;
    tell_between_turns(application, ALARM_STUCK_CAPTURE);
    begin_with_nothing(application);
    core_control(&application->core, false, true, CAPTURE_OFF);
    set_control(application);
    application->position_at_bank = position;
}

/* Samples that others ask for may fail to come: no fault of the capture. */
static void watch_capture(struct application *application) {
    if (application_capture(application) == CAPTURE_BY_SYNC) {
        return;
    }
    int32_t position = core_position(&application->core).head1_position;
    double moved = fabs((double)counts_apart(position, application->position_at_bank));
    if (moved > STUCK_TURNS * application->parameters.counts_per_rev) {
        capture_is_stuck(application, position);
    }
}

/* The angle is known now, the word of then: the travel between them is right when words wrap. */
static uint32_t angle_offset(const struct core_position *position, int32_t first_word,
                             uint32_t counts_per_rev) {
    int64_t travel = counts_apart(position->head1_turn_position, first_word);
    int64_t first_angle = (int64_t)position->head1_angle - travel;
    int64_t offset = (first_angle - first_word) % counts_per_rev;
    return (uint32_t)(offset < 0 ? offset + counts_per_rev : offset);
}

/* The estimate of a turn is that of its middle, and by now the table is warmer. */
static void follow_middle(struct application *application) {
    double now_s = seconds(application);
    double clock_hz = application->configuration.clock_hz;
    double celsius = application->table.celsius;
    double half_s = 0.0;
    if (application->temperature_clock_hz > 0.0) {
        clock_hz = application->temperature_clock_hz;
    }
    if (application->before_s > 0.0 && clock_hz > 0.0) {
        half_s = 0.5 * (now_s - fmax((double)application->header.start_time / clock_hz,
                                     application->before_s));
    }
    double span_s = now_s - application->before_s;
    double change_k = application->before_s > 0.0 ? celsius - application->before_celsius : 0.0;
    bool between = half_s > 0.0 && span_s > half_s;
    application->middle_celsius = celsius - (between ? change_k * half_s / span_s : 0.0);
}

static void take_bank(struct application *application) {
    const struct core_access *core = &application->core;
    struct core_position position = core_position(core);
    struct core_header header = core_capture_header(core);
    uint32_t turn = (uint32_t)application->parameters.counts_per_rev;
    uint32_t depth = application->configuration.capture_depth;
    uint32_t samples = header.samples < depth ? header.samples : depth;
    application->header = header;
    follow_middle(application);
    application->position_at_bank = position.head1_position;
    const volatile int32_t *words = samples ? core->capture(core->context, 2 * samples) : NULL;
    application->capture = (struct capture){
        .words = words,
        .samples = samples,
        .flags = header.flags,
        .counts_per_rev = turn,
        .angle_offset = words != NULL ? angle_offset(&position, words[0], turn) : 0,
        .head2_zero = application->head2_zero,
        .period_clocks = application_capture(application) == CAPTURE_BY_TIME
                             ? (uint32_t)application->parameters.sample_period
                             : 0U,
        .clock_hz = application->configuration.clock_hz,
    };
}

static uint32_t alarms_of(struct application *application) {
    const struct parameters *parameters = &application->parameters;
    const struct estimate *estimate = &application->estimate;
    double off_rad = estimate->measured_separation_rad - parameters->separation_deg * PI / 180.0;
    uint32_t overruns = core_overrun_count(&application->core);
    uint32_t alarms = 0;
    if (application->report.result != TURN_REFUSED) {
        double error = application->report.prediction.active_arcsec;
        alarms |= estimate->noise_arcsec > parameters->alarm_noise_arcsec ? ALARM_NOISE : 0;
        bool wrong = error > parameters->alarm_error_arcsec || application->load.watch.at_fault;
        alarms |= application->has_active && wrong ? ALARM_ERROR : 0;
        alarms |= fabs(off_rad) * ARCSEC_PER_RAD > parameters->alarm_separation_arcsec
                      ? ALARM_SEPARATION
                      : 0;
    }
    alarms |= application->report.reason == REFUSED_HEADS_EXCHANGED ? ALARM_SEPARATION : 0;
    const struct core_status status = core_status(&application->core);
    application->report.output_stands = status.cannot_keep_up;
    application->report.release_causes = status.release_causes;
    alarms |= status.cannot_keep_up || status.release_causes != 0 ? ALARM_OUTPUT : 0;
    alarms |= overruns != application->overruns ? ALARM_OVERRUN : 0;
    application->overruns = overruns;
    bool hot = application->report.has_temperature &&
               application->report.temperature_c > parameters->alarm_temperature_c;
    alarms |= hot ? ALARM_TEMPERATURE : 0;
    alarms |= table_temperature_is_held(&application->table) ? ALARM_THERMOMETER : 0;
    alarms |= application->faults_in_a_row != 0 ? ALARM_BEGAN_ANEW : 0;
    return alarms;
}

/* False: the idle bank does not hold what was written. */
static bool load_candidate(struct application *application) {
    const struct core_access *core = &application->core;
    core_write_coefficients(core, &application->candidate);
    if (!core_verify_coefficients(core, &application->candidate)) {
        return false;
    }
    application->swaps_before = core_swap_count(core);
    core_swap(core);
    application->active = application->candidate;
    application->has_active = true;
    application->forgotten = false;
    application->inherited = false;
    application->swaps++;
    application->swap_looks = 0;
    application->phase = PHASE_SWAP;
    set_control(application);
    return true;
}

static enum turn_result result_of(enum refusal reason, bool frozen) {
    if (reason == NOT_REFUSED) {
        return frozen ? TURN_KEPT : TURN_APPLIED;
    }
    return reason == REFUSED_NOT_BETTER ? TURN_KEPT : TURN_REFUSED;
}

static void take_temperature(struct application *application) {
    struct turn_report *report = &application->report;
    report->has_temperature =
        application->read_temperature != NULL &&
        application->read_temperature(application->temperature_context, &report->temperature_c);
}

/* Nothing that the core knows proves anything for turns: the zeros are found anew, uncorrected until
   then. The coefficients belong to the index and stay. */
static void find_zeros_anew(struct application *application) {
    core_rearm(&application->core);
    core_disarm_compare(&application->core);
    forget_zeros(application);
    tell_between_turns(application, ALARM_ZERO_LOST);
    application->phase = PHASE_WAIT_FOR_INDEX;
}

/* Head 1's angle at its index is not 0: counts were lost, or the mark is false. The correction stays
   on, beside its place by that: the core moves the zero when a mark is proven. A mark far from
   the index is rather a pulse that is none. */
static void watch_doubt(struct application *application) {
    if (!application->zero_in_doubt && !core_head_index_error(&application->core, 0)) {
        return;
    }
    double off = fabs((double)zero_of(application, 0, 0));
    int32_t position = core_position(&application->core).head1_position;
    if (off == 0.0 || off > LOST_TURNS_MOST * application->parameters.counts_per_rev) {
        application->zero_in_doubt = false;
    } else if (!application->zero_in_doubt) {
        application->zero_in_doubt = true;
        application->position_at_doubt = position;
    } else if (fabs((double)counts_apart(position, application->position_at_doubt)) >
               DOUBT_TURNS * application->parameters.counts_per_rev) {
        find_zeros_anew(application);
    }
}

/* Where an index says that head 2 lost counts: what its zero is off by is taken off its words from
   the next turn on. Every change of it is an index error of the turn in which it came, so that no
   turn is taken with another's. */
static void follow_head2_zero(struct application *application) {
    int32_t zero = zero_of(application, 1, application->head2_zero);
    application->report.alarms |= zero != application->head2_zero ? ALARM_ZERO_LOST : 0;
    application->head2_zero = zero;
}

/* The core has moved the zero of head 1, with the correction on, since it was looked at. */
static bool zero_has_moved(struct application *application) {
    uint32_t moves = core_zero_moves(&application->core);
    bool moved = moves != application->zero_moves;
    application->zero_moves = moves;
    application->report.alarms |= moved ? ALARM_ZERO_LOST : 0;
    if (moved && core_status(&application->core).compare_armed) {
        arm_compare(application);
    }
    return moved;
}

void application_want_dump(struct application *application) {
    application->dump = DUMP_WANTED;
    if (application->by_angle) {
        application->by_angle = false;
        capture_anew(application);
    }
}

/* The flags are sticky: the next turn is to be judged by itself. An index error that came since the
   refused turn ended is about to be cleared and is looked at here as well. */
static void after_refusal(struct application *application) {
    bool told = application->report.reason == REFUSED_INDEX_ERROR ||
                core_index_error(&application->core);
    if (told) {
        watch_doubt(application);
        follow_head2_zero(application);
    }
    core_clear_faults(&application->core);
    bool swings = application->report.reason == REFUSED_WRONG_STEP &&
                  application_capture(application) == CAPTURE_BY_TIME;
    application->by_angle = application->by_angle || swings;
    if (zero_has_moved(application) || swings) {
        capture_anew(application);
    }
}

static void forget_old_faults(struct application *application) {
    if (application->faults_in_a_row != 0 && application->turns >= FAULT_FORGOTTEN_TURNS) {
        application->faults_in_a_row = 0;
        keep_settings(application);
    }
}

/* What was loaded or saved is applied while the calibration is frozen, too. */
static void take_set(struct application *application) {
    struct load *load = &application->load;
    enum candidate_origin origin = application->candidate_origin;
    if (!load_candidate(application)) {
        application->report.result = TURN_KEPT;
        application->report.alarms |= ALARM_COEFFICIENTS;
        if (origin == OF_LOAD) {
            load_refuse(load, LOAD_NOT_READ_BACK);
        }
        return;
    }
    application->report.result = TURN_APPLIED;
    if (origin == OF_LOAD) {
        load_take_over_received(load);
    } else if (origin == OF_PENDING) {
        load_at_work_again(load);
    } else {
        const struct saved *saved = &application->save->content;
        application->saved_state = SAVED_CONFIRMED;
        load_take_over(load, &saved->loaded, &saved->thermal, saved->unjudged);
    }
}

static void process_bank(struct application *application) {
    struct turn_report *report = &application->report;
    *report = (struct turn_report){
        .number = ++application->turns,
        .sequence_number = application->header.sequence_number,
        .start_time = application->header.start_time,
        .samples = application->header.samples,
    };
    bool waited = application->saved_state == SAVED_WAITING;
    take_temperature(application);
    report->reason = calibrate_turn(application);
    report->result = result_of(report->reason, application->frozen);
    application->refusals[report->reason] += report->reason != NOT_REFUSED;
    report->alarms = alarms_of(application);
    if (report->result == TURN_REFUSED) {
        after_refusal(application);
    }
    if (application->saved_state == SAVED_NOT_CONFIRMED && waited) {
        report->alarms |= ALARM_SAVED;
    }
    if (application->candidate_origin != OF_TURN) {
        take_set(application);
    } else if (report->result == TURN_APPLIED && !load_candidate(application)) {
        report->result = TURN_KEPT;
        report->alarms |= ALARM_COEFFICIENTS;
    }
    report->fresh = true;
    forget_old_faults(application);
}

static void finish_bank(struct application *application) {
    application->phase = PHASE_CAPTURE;
    process_bank(application);
    bool known = table_temperature_is_known(&application->table);
    application->before_celsius = application->table.celsius;
    application->before_s = known ? seconds(application) : 0.0;
    core_release_capture(&application->core);
}

/* At the index that proves it, not with the bank: that may be full minutes later. */
static void watch_zero(struct application *application) {
    watch_doubt(application);
    if (zero_has_moved(application)) {
        tell_between_turns(application, ALARM_ZERO_LOST);
        follow_head2_zero(application);
        core_clear_faults(&application->core);
        capture_anew(application);
        give_back_old_bank(application);
    }
}

/* A table that its drive has stopped brings no turn that would clear the flags of a head. What an index error says is
   looked at first. Turns that were captured, and the one under way, may hold what the flag was set for. */
static void look_before_clearing(struct application *application, uint32_t faults) {
    if (!works(application) || (faults & HEAD_FAULTS) == 0) {
        return;
    }
    if (core_index_error(&application->core)) {
        int32_t zero = application->head2_zero;
        watch_doubt(application);
        follow_head2_zero(application);
        if (zero != application->head2_zero) {
            tell_between_turns(application, ALARM_ZERO_LOST);
        }
    }
    capture_anew(application);
    give_back_old_bank(application);
}

enum output_answer application_clear_output(struct application *application) {
    if (application->phase == PHASE_NO_CORE) {
        return OUTPUT_NO_CORE;
    }
    struct core_status before = core_status(&application->core);
    if (!before.cannot_keep_up && before.release_causes == 0) {
        return OUTPUT_NO_FAULT;
    }
    look_before_clearing(application, before.release_present);
    core_clear_output(&application->core, before.release_present);
    struct core_status after = core_status(&application->core);
    if (after.cannot_keep_up) {
        return OUTPUT_FAULT_AGAIN;
    }
    if (after.release_causes != 0) {
        return OUTPUT_STAYS_RELEASED;
    }
    return before.cannot_keep_up ? OUTPUT_CLEARED : OUTPUT_DRIVEN;
}

/* A core that is worked with always has its output enabled. Its line drivers outlast a reset for some milliseconds
   only. */
static void watch_reset(struct application *application) {
    if (!core_output_enabled(&application->core)) {
        application_start(application);
        tell_between_turns(application, ALARM_CORE_RESET);
    }
}

/* At once: a table that its drive has stopped brings no turn to tell it with. */
static void watch_release(struct application *application) {
    uint32_t causes = application_release_causes(application);
    if (causes != 0 && !application->release_told) {
        tell_between_turns(application, ALARM_OUTPUT);
    }
    application->report.release_causes = causes;
    application->release_told = causes != 0;
}

/* The loaded lanes at the table's temperature, where that changes the correction by more than the
   operator wants. Between two turns: a turn that is ready goes first. */
static void follow_temperature(struct application *application) {
    const struct load *load = &application->load;
    const struct thermal *thermal = application_thermal(application, &load->thermal);
    if (!application->has_active || thermal == NULL || thermal->lanes == 0 ||
        load_at_work(load) == NULL) {
        return;
    }
    application->candidate = application->active;
    for (uint32_t place = 0; place < application->candidate.lanes; place++) {
        struct lane *lane = &application->candidate.lane[place];
        const struct lane *written = coefficients_lane_of(&load->loaded, lane->order);
        if (written != NULL) {
            *lane = thermal_lane_at(thermal, written, application->table.celsius);
        }
    }
    if (thermal_apart_counts(&application->candidate, &application->active) <=
        application->parameters.temperature_step_counts) {
        return;
    }
    if (load_candidate(application)) {
        application->temperature_swaps++;
    } else {
        tell_between_turns(application, ALARM_COEFFICIENTS);
    }
}

/* Of the model that is judged next, or else of the one that is at work. */
static const struct thermal *thermal_in_use(const struct application *application) {
    if (application->saved_state == SAVED_WAITING) {
        return &application->save->content.thermal;
    }
    const struct load *load = &application->load;
    return load->whole ? &load->received_thermal : &load->thermal;
}

static void read_table_temperature(struct application *application) {
    const struct parameters *parameters = &application->parameters;
    const struct temperature_limits limits = {
        .jump_k = parameters->temperature_jump_k,
        .still_s = parameters->temperature_still_s,
    };
    table_temperature_follow(&application->table, &limits,
                             thermal_in_use(application)->time_constant_ms / 1000.0,
                             seconds(application));
}

/* For the console, which takes seconds to tell it. The die's temperature is that of now. */
static void copy_bank(struct application *application) {
    struct capture_copy *copy = application->copy;
    double celsius;
    if (!capture_copy_take(copy, &application->capture)) {
        application->dump = DUMP_NOT_COPIED;
        return;
    }
    copy->sequence_number = application->header.sequence_number;
    copy->start_time = application->header.start_time;
    copy->separation_udeg = (int32_t)rint(application->parameters.separation_deg * 1e6);
    copy->has_temperature =
        application->read_temperature != NULL &&
        application->read_temperature(application->temperature_context, &celsius);
    copy->temperature_cdeg = copy->has_temperature ? (int32_t)rint(celsius * 100.0) : 0;
    application->dump = DUMP_COPIED;
}

static void look_for_bank(struct application *application) {
    if (!core_status(&application->core).capture_ready) {
        watch_capture(application);
        watch_zero(application);
        if (application->phase == PHASE_CAPTURE) {
            follow_temperature(application);
        }
        return;
    }
    application->banks_without_interrupt += !application->interrupted;
    application->interrupted = false;
    take_bank(application);
    if (application->dump == DUMP_WANTED) {
        copy_bank(application);
    }
    finish_bank(application);
}

/* Which coefficients are active is not known: safe is none. */
static void swap_is_lost(struct application *application) {
    tell_between_turns(application, ALARM_SWAP);
    begin_with_nothing(application);
}

static void wait_for_swap(struct application *application) {
    bool swapped = core_swap_count(&application->core) != application->swaps_before;
    if (swapped || ++application->swap_looks > SWAP_LOOKS_MOST) {
        application->phase = PHASE_CAPTURE;
    }
    if (!swapped && application->phase == PHASE_CAPTURE) {
        swap_is_lost(application);
    }
}

void application_interrupt(struct application *application) {
    application->interrupts++;
    if (application->phase != PHASE_NO_CORE) {
        application->interrupted = true;
        core_acknowledge_interrupt(&application->core);
    }
}

bool application_busy(const struct application *application) {
    return application->phase == PHASE_SWAP;
}

void application_step(struct application *application) {
    if (application->save != NULL) {
        save_step(application->save);
    }
    if (works(application)) {
        watch_reset(application);
        read_table_temperature(application);
        watch_release(application);
    }
    switch (application->phase) {
    case PHASE_WAIT_FOR_INDEX:
        wait_for_index(application);
        break;
    case PHASE_CAPTURE:
        look_for_bank(application);
        break;
    case PHASE_SWAP:
        wait_for_swap(application);
        break;
    case PHASE_NO_CORE:
    case PHASE_HELD:
    default:
        break;
    }
}
