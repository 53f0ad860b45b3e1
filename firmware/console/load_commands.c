/* SPDX-License-Identifier: Apache-2.0 */

#include "load_commands.h"

#include <math.h>

#include "arctrue_number_formats.h"
#include "assertion.h"
#include "local_table.h"
#include "prepared.h"

/* sim/arctrue/device/load.py writes these frames and states which numbers each frame has. */
const char load_use[] =
    "load status | load abort | load phase N DEGREES TURN | load begin, lane, "
    "slope, temperature, range, "
    "followed, conditions, real, source, table, points, mean, head, without, without_head, "
    "without_lane, force, end NUMBERS CRC: "
    "arctrue load sends these lines";

#define WORD_MOST 4294967295.0
#define TURN_MOST 8388607.0
#define PHASE_MOST_DEG 360.0

enum { ARCSEC_DECIMALS = 6, ORDER_DECIMALS = 9 };
enum {
    BEGIN_WORDS = 5,
    LANE_WORDS = 7,
    SLOPE_WORDS = 9,
    TEMPERATURE_WORDS = 5,
    RANGE_WORDS = 5,
    FOLLOWED_WORDS = 8,
    CONDITIONS_WORDS = 6,
    REAL_WORDS = 8,
    SOURCE_WORDS = 7,
    TABLE_WORDS = 8,
    POINTS_WORDS = 3 + 1 + LOAD_POINTS,
    PHASE_WORDS = 5,
    MEAN_FRAME_WORDS = 7,
    HEAD_WORDS = 6,
    WITHOUT_WORDS = 8,
    FORCE_WORDS = 4,
    END_WORDS = 3
};

static void answer(struct console *console, enum load_answer given) {
    if (given == LOAD_TAKEN) {
        text_line(&console->sink, "ok");
        return;
    }
    text_error(&console->sink, "load ", load_answer_name(given));
}

/* Parses `number` words: whole numbers, and a CRC as the last word. Returns false if a word is not such a number. It
   does not compare the CRC. */
static bool read_numbers(char *const *words, uint32_t number, int64_t *values, uint32_t *crc) {
    for (uint32_t place = 0; place + 1 < number; place++) {
        if (!text_parse_whole(words[place], WORD_MOST, &values[place])) {
            return false;
        }
    }
    return text_parse_hexadecimal(words[number - 1], crc);
}

static void begin_frame(struct console *console, char *const *words) {
    struct application *application = console->application;
    int64_t values[2];
    uint32_t crc;
    if (application->phase == PHASE_NO_CORE) {
        text_line(&console->sink, "error: no core");
    } else if (!read_numbers(words, 3, values, &crc)) {
        answer(console, LOAD_WRONG_CRC);
    } else {
        answer(console, load_begin(&application->load, (uint32_t)values[0], (uint32_t)values[1],
                                   application->configuration.lanes, crc));
    }
}

static bool fits(int64_t value) {
    return value >= INT32_MIN && value <= INT32_MAX;
}

/* Receives a lane of the set or, if `is_without` is true, of the set for a missing head. */
static void lane_frame(struct console *console, char *const *words, bool is_without) {
    struct application *application = console->application;
    int64_t values[4];
    uint32_t crc;
    if (!read_numbers(words, 5, values, &crc) || !fits(values[3])) {
        answer(console, LOAD_WRONG_CRC);
        return;
    }
    uint32_t number = (uint32_t)values[0];
    const struct lane set = {
        .order = (uint32_t)values[1],
        .phase_offset = (uint32_t)values[2],
        .amplitude = (int32_t)values[3],
    };
    answer(console, is_without ? application_load_without_lane(application, number, &set, crc)
                               : load_lane(&application->load, number, set.order, set.phase_offset,
                                           set.amplitude, crc));
}

static void slope_frame(struct console *console, char *const *words) {
    int64_t values[6];
    uint32_t crc;
    bool read = read_numbers(words, 7, values, &crc);
    if (!read || !fits(values[2]) || !fits(values[3]) || !fits(values[4]) || !fits(values[5])) {
        answer(console, LOAD_WRONG_CRC);
        return;
    }
    const struct thermal_lane follows = {
        .order = (uint32_t)values[1],
        .cosine = (int32_t)values[2],
        .sine = (int32_t)values[3],
        .cosine_squared = (int32_t)values[4],
        .sine_squared = (int32_t)values[5],
    };
    answer(console, load_slope(&console->application->load, (uint32_t)values[0], &follows, crc));
}

static void temperature_frame(struct console *console, char *const *words) {
    int64_t values[2];
    uint32_t crc;
    if (!read_numbers(words, 3, values, &crc) || !fits(values[0])) {
        answer(console, LOAD_WRONG_CRC);
        return;
    }
    answer(console, load_temperature(&console->application->load, (int32_t)values[0],
                                     (uint32_t)values[1], crc));
}

static void range_frame(struct console *console, char *const *words) {
    int64_t values[2];
    uint32_t crc;
    if (!read_numbers(words, 3, values, &crc) || !fits(values[0]) || !fits(values[1])) {
        answer(console, LOAD_WRONG_CRC);
        return;
    }
    answer(console,
           load_range(&console->application->load, (int32_t)values[0], (int32_t)values[1], crc));
}

static void followed_frame(struct console *console, char *const *words) {
    int64_t values[5];
    uint32_t crc;
    if (!read_numbers(words, 6, values, &crc) || !fits(values[4])) {
        answer(console, LOAD_WRONG_CRC);
        return;
    }
    const struct followed_lane follower = {
        .lane = {.order = (uint32_t)values[2],
                 .phase_offset = (uint32_t)values[3],
                 .amplitude = (int32_t)values[4]},
        .modulator = (uint32_t)values[1],
    };
    answer(console,
           load_followed(&console->application->load, (uint32_t)values[0], &follower, crc));
}

static void real_frame(struct console *console, char *const *words) {
    int64_t values[5];
    uint32_t crc;
    if (!read_numbers(words, 6, values, &crc) || !fits(values[4])) {
        answer(console, LOAD_WRONG_CRC);
        return;
    }
    const struct real_lane lane_of_real_order = {
        .order = (uint32_t)values[1],
        .turn_step = (uint64_t)(uint32_t)values[3] << 32 | (uint32_t)values[2],
        .amplitude = (int32_t)values[4],
    };
    answer(console,
           load_real(&console->application->load, (uint32_t)values[0], &lane_of_real_order, crc));
}

/* Sets the source of the phase of a lane of a real order. */
static void source_frame(struct console *console, char *const *words) {
    int64_t values[4];
    uint32_t crc;
    if (!read_numbers(words, 5, values, &crc) || !fits(values[2])) {
        answer(console, LOAD_WRONG_CRC);
        return;
    }
    const struct real_lane lane_with_source = {
        .source = (uint32_t)values[1],
        .side = (int32_t)values[2],
        .probe_phase = (uint32_t)values[3],
    };
    answer(console, load_phase_source(&console->application->load, (uint32_t)values[0],
                                      &lane_with_source, crc));
}

/* Sets the phase of a lane; the operator knows this phase from a probe, an index of the drive or a reference. */
static void phase_frame(struct console *console, char *const *words) {
    int64_t number;
    int64_t turn;
    double degrees;
    if (!text_parse_whole(words[0], WORD_MOST, &number)) {
        text_error(&console->sink, "a lane has a number, not ", words[0]);
    } else if (!text_parse_decimal(words[1], &degrees) || !(fabs(degrees) <= PHASE_MOST_DEG)) {
        text_error(&console->sink, "a phase is -360 to 360, not ", words[1]);
    } else if (!text_parse_whole(words[2], TURN_MOST, &turn)) {
        text_error(&console->sink, "a turn is a whole number, not ", words[2]);
    } else {
        double turns = degrees / PHASE_MOST_DEG;
        double word = rint((turns - floor(turns)) * (1 << ARCTRUE_PHASE_WIDTH));
        uint32_t in_turn = (uint32_t)word % (1U << ARCTRUE_PHASE_WIDTH);
        if (load_phase(&console->application->load, (uint32_t)number, in_turn, (int32_t)turn)) {
            text_line(&console->sink, "ok");
        } else {
            text_error(&console->sink, "no lane of a real order is active with number ", words[0]);
        }
    }
}

static void conditions_frame(struct console *console, char *const *words) {
    int64_t values[3];
    uint32_t crc;
    if (!read_numbers(words, 4, values, &crc)) {
        answer(console, LOAD_WRONG_CRC);
        return;
    }
    answer(console, load_conditions(&console->application->load, (uint32_t)values[0],
                                    (uint32_t)values[1], (uint32_t)values[2], crc));
}

static void mean_frame(struct console *console, char *const *words) {
    int64_t values[4];
    uint32_t crc;
    if (!read_numbers(words, 5, values, &crc) || !fits(values[2])) {
        answer(console, LOAD_WRONG_CRC);
        return;
    }
    const struct mean_set set = {
        .carrier = (uint32_t)values[0],
        .used = (uint32_t)values[1],
        .error_offset = (int32_t)values[2],
        .delays = (uint32_t)values[3],
    };
    answer(console, load_mean(&console->application->load, &set, crc));
}

/* Receives weight and offset of a head of the mean or, if `is_without` is true, of the set for a missing head. */
static void head_frame(struct console *console, char *const *words, bool is_without) {
    struct application *application = console->application;
    int64_t values[3];
    uint32_t crc;
    if (!read_numbers(words, 4, values, &crc) || !fits(values[1])) {
        answer(console, LOAD_WRONG_CRC);
        return;
    }
    uint32_t number = (uint32_t)values[0];
    int32_t weight = (int32_t)values[1];
    uint32_t offset = (uint32_t)values[2];
    answer(console, is_without
                        ? application_load_without_head(application, number, weight, offset, crc)
                        : load_head(&application->load, number, weight, offset, crc));
}

static void without_frame(struct console *console, char *const *words) {
    int64_t values[5];
    uint32_t crc;
    if (!read_numbers(words, 6, values, &crc) || !fits(values[4])) {
        answer(console, LOAD_WRONG_CRC);
        return;
    }
    const struct mean_set set = {
        .carrier = (uint32_t)values[2],
        .used = (uint32_t)values[3],
        .error_offset = (int32_t)values[4],
    };
    answer(console, application_load_without(console->application, (uint32_t)values[0],
                                             (uint32_t)values[1], &set, crc));
}

static void table_frame(struct console *console, char *const *words) {
    int64_t values[5];
    uint32_t crc;
    if (!read_numbers(words, 6, values, &crc)) {
        answer(console, LOAD_WRONG_CRC);
        return;
    }
    const struct table_place place = {
        .choice = (uint32_t)values[0],
        .start = {(uint32_t)values[1], (uint32_t)values[2], (uint32_t)values[3],
                  (uint32_t)values[4]},
    };
    answer(console, application_load_table(console->application, &place, crc));
}

static void points_frame(struct console *console, char *const *words) {
    int64_t values[1 + LOAD_POINTS];
    int32_t of_frame[LOAD_POINTS];
    uint32_t crc;
    bool read = read_numbers(words, 2 + LOAD_POINTS, values, &crc);
    for (uint32_t place = 0; read && place < LOAD_POINTS; place++) {
        read = fits(values[place + 1]);
        of_frame[place] = (int32_t)values[place + 1];
    }
    answer(console,
           read ? application_load_points(console->application, (uint32_t)values[0], of_frame, crc)
                : LOAD_WRONG_CRC);
}

static void force_frame(struct console *console, char *const *words) {
    int64_t value;
    uint32_t crc;
    bool read = read_numbers(words, 2, &value, &crc);
    answer(console,
           read ? load_force(&console->application->load, (uint32_t)value, crc) : LOAD_WRONG_CRC);
}

static void end_frame(struct console *console, char *const *words) {
    uint32_t crc;
    bool read = text_parse_hexadecimal(words[0], &crc);
    answer(console, read ? application_load_end(console->application, crc) : LOAD_WRONG_CRC);
}

static void order_line(struct console *console, const char *name, uint32_t order) {
    text_word(&console->sink, name);
    text_unsigned(&console->sink, order);
    text_line(&console->sink, "");
}

/* Prints one line with `name` and the order for each lane of `set` whose bit is set in `places`. */
static void order_lines(struct console *console, const char *name, const struct coefficients *set,
                        uint64_t places) {
    ASSERT(set->lanes <= LANES_LIMIT);
    for (uint32_t place = 0; place < set->lanes; place++) {
        if ((places >> place & 1U) != 0) {
            order_line(console, name, set->lane[place].order);
        }
    }
}

/* Prints the lanes of real orders by ascending lane number, and the number of the core's present turn. */
static void tell_real(struct console *console, const struct followed *loaded) {
    ASSERT(loaded->real_lanes <= REAL_LANES_MAX);
    for (uint32_t place = 0; place < loaded->real_lanes; place++) {
        const struct real_lane *one = &loaded->real[place];
        text_word(&console->sink, "real_order ");
        text_fixed(&console->sink, real_lane_order(one), ORDER_DECIMALS);
        text_word(&console->sink, one->phase_known ? " phase_known" : " phase_unknown");
        text_line(&console->sink, "");
    }
    if (loaded->real_lanes != 0) {
        text_word(&console->sink, "turn_number ");
        text_signed(&console->sink, core_turn_number(&console->application->core));
        text_line(&console->sink, "");
    }
}

static void tell_loaded(struct console *console, const struct load *load) {
    ASSERT(load->loaded.lanes <= LANES_LIMIT);
    for (uint32_t place = 0; place < load->loaded.lanes; place++) {
        uint32_t order = load->loaded.lane[place].order;
        if (order == 0) {
            continue;
        }
        order_line(console, "loaded_order ", order);
        double left = watch_left(&load->watch, place);
        if (left >= 0.0) {
            text_word(&console->sink, "left_arcsec ");
            text_unsigned(&console->sink, order);
            text_word(&console->sink, " ");
            text_fixed(&console->sink, left, ARCSEC_DECIMALS);
            text_line(&console->sink, "");
        }
    }
    order_lines(console, "unjudged_order ", &load->loaded, load->unjudged);
    tell_real(console, &load->followed);
    if (load->table.place.choice != 0) {
        text_word(&console->sink, "loaded_table_crc ");
        text_hexadecimal(&console->sink, load->table.crc);
        text_line(&console->sink, "");
    }
    text_word(&console->sink, "loaded_crc ");
    text_hexadecimal(&console->sink, load->loaded_crc);
    text_line(&console->sink, "");
}

static void send_load_status(struct console *console) {
    const struct load *load = &console->application->load;
    text_word(&console->sink, "load ");
    text_word(&console->sink, load_state_name(load->state));
    if (load->state == LOAD_REFUSED) {
        text_word(&console->sink, " ");
        text_word(&console->sink, load_answer_name(load->reason));
    }
    text_line(&console->sink, "");
    if (load->state == LOAD_REFUSED && load->refused_order != 0) {
        order_line(console, "refused_order ", load->refused_order);
    }
    if (load->whole) {
        order_lines(console, "undecided_order ", &load->received, load->undecided);
    }
    if (load_waits_for(load, true)) {
        text_line(&console->sink, "waits_for the_other_direction");
    }
    if (load_waits_for(load, false)) {
        text_line(&console->sink, "waits_for another_speed");
    }
    if (load_at_work(load) != NULL) {
        tell_loaded(console, load);
    }
    text_line(&console->sink, "ok");
}

void load_command(struct console *console, char *const *words, uint32_t number) {
    const char *what = words[1];
    if (text_equal(what, "begin") && number == BEGIN_WORDS) {
        begin_frame(console, words + 2);
    } else if (text_equal(what, "lane") && number == LANE_WORDS) {
        lane_frame(console, words + 2, false);
    } else if (text_equal(what, "slope") && number == SLOPE_WORDS) {
        slope_frame(console, words + 2);
    } else if (text_equal(what, "temperature") && number == TEMPERATURE_WORDS) {
        temperature_frame(console, words + 2);
    } else if (text_equal(what, "range") && number == RANGE_WORDS) {
        range_frame(console, words + 2);
    } else if (text_equal(what, "followed") && number == FOLLOWED_WORDS) {
        followed_frame(console, words + 2);
    } else if (text_equal(what, "real") && number == REAL_WORDS) {
        real_frame(console, words + 2);
    } else if (text_equal(what, "source") && number == SOURCE_WORDS) {
        source_frame(console, words + 2);
    } else if (text_equal(what, "phase") && number == PHASE_WORDS) {
        phase_frame(console, words + 2);
    } else if (text_equal(what, "table") && number == TABLE_WORDS) {
        table_frame(console, words + 2);
    } else if (text_equal(what, "points") && number == POINTS_WORDS) {
        points_frame(console, words + 2);
    } else if (text_equal(what, "conditions") && number == CONDITIONS_WORDS) {
        conditions_frame(console, words + 2);
    } else if (text_equal(what, "mean") && number == MEAN_FRAME_WORDS) {
        mean_frame(console, words + 2);
    } else if (text_equal(what, "head") && number == HEAD_WORDS) {
        head_frame(console, words + 2, false);
    } else if (text_equal(what, "without") && number == WITHOUT_WORDS) {
        without_frame(console, words + 2);
    } else if (text_equal(what, "without_head") && number == HEAD_WORDS) {
        head_frame(console, words + 2, true);
    } else if (text_equal(what, "without_lane") && number == LANE_WORDS) {
        lane_frame(console, words + 2, true);
    } else if (text_equal(what, "force") && number == FORCE_WORDS) {
        force_frame(console, words + 2);
    } else if (text_equal(what, "end") && number == END_WORDS) {
        end_frame(console, words + 2);
    } else if (text_equal(what, "status") && number == 2) {
        send_load_status(console);
    } else if (text_equal(what, "abort") && number == 2) {
        load_abort(&console->application->load);
        text_line(&console->sink, "ok");
    } else {
        text_error(&console->sink, "use: ", load_use);
    }
}
