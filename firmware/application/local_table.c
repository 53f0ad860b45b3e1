/* SPDX-License-Identifier: Apache-2.0 */

#include "local_table.h"

#include <math.h>

#include "arctrue_number_formats.h"
#include "assertion.h"
#include "crc32.h"
#include "units.h"
#include "vector.h"

/* Tells whether there is a core with a local table. Any other core answers an access to the table's words with a bus
   error. */
static bool local_table_exists(const struct application *application) {
    return state_works(application) && core_origin(&application->core).has_local_table;
}

enum load_answer application_load_table(struct application *application,
                                        const struct table_place *place, uint32_t crc) {
    if (!local_table_exists(application)) {
        return LOAD_NO_LOCAL_TABLE;
    }
    return load_table(&application->load, place, crc);
}

enum load_answer application_load_points(struct application *application, uint32_t number,
                                         const int32_t points[LOAD_POINTS], uint32_t crc) {
    if (!local_table_exists(application) ||
        (application->save != NULL && application->save->state != SAVE_IDLE)) {
        /* The record that is being written takes its points from the idle bank; new points must not overwrite these. */
        return LOAD_WRONG_FRAME;
    }
    enum load_answer answer = load_points(&application->load, number, points, crc);
    for (uint32_t place = 0; answer == LOAD_TAKEN && place < LOAD_POINTS; place++) {
        if (number + place < TABLE_POINTS) {
            core_write_table_point(&application->core, number + place, points[place]);
        }
    }
    return answer;
}

static uint32_t local_table_sum(const struct application *application) {
    uint32_t crc = 0;
    for (uint32_t number = 0; number < TABLE_POINTS; number++) {
        crc = crc32_add_word(crc, (uint32_t)core_table_point(&application->core, number));
    }
    return crc;
}

void local_table_complete(struct application *application) {
    struct load_table *table = &application->load.received_table;
    for (uint32_t number = table->next; number < TABLE_POINTS && table->place.choice != 0;
         number++) {
        core_write_table_point(&application->core, number, 0);
    }
    /* The CRC covers the sent points and the zeros after them. */
    for (; table->next < TABLE_POINTS; table->next++) {
        table->crc = crc32_add_word(table->crc, 0);
    }
}

int32_t local_table_point(const void *context, uint32_t number) {
    const struct application *application = context;
    return core_table_point(&application->core, number);
}

bool local_table_is_held(const struct application *application, uint32_t crc) {
    return local_table_exists(application) && local_table_sum(application) == crc;
}

bool local_table_restore(const struct application *application) {
    struct save *save = application->save;
    uint32_t words[FLASH_PAGE_WORDS];
    uint32_t crc = save->content.table.crc;
    if (local_table_is_held(application, crc)) {
        return true;
    }
    if (!local_table_exists(application)) {
        return false;
    }
    for (uint32_t first = 0; first < TABLE_POINTS; first += FLASH_PAGE_WORDS) {
        if (!save_read_points(save, first, words)) {
            return false;
        }
        for (uint32_t word = 0; word < FLASH_PAGE_WORDS; word++) {
            core_write_table_point(&application->core, first + word, (int32_t)words[word]);
        }
    }
    return local_table_sum(application) == crc;
}

/* Returns the value of the table, counts, from the points in the idle bank. */
static double local_table_value(const struct application *application,
                                const struct table_place *of_table, int32_t angle,
                                uint32_t counts_per_rev) {
    uint32_t windows = load_table_windows(of_table);
    uint32_t points = TABLE_POINTS / windows;
    double width = (double)counts_per_rev / (double)(1U << load_table_width(of_table));
    for (uint32_t window = 0; window < windows; window++) {
        int64_t since = ((int64_t)angle - of_table->start[window]) % counts_per_rev;
        since += since < 0 ? counts_per_rev : 0;
        if ((double)since < width) {
            double place = (double)since / width * points;
            uint32_t below = (uint32_t)place;
            int32_t first = core_table_point(&application->core, window * points + below);
            int32_t next =
                core_table_point(&application->core, window * points + (below + 1) % points);
            return (first + (place - below) * (next - first)) * load_table_unit(of_table);
        }
    }
    return 0.0;
}

/* Returns the error of the fitted orders at a reading, arcsec. */
static double local_table_fitted(const struct estimate *estimate, double angle_rad) {
    const struct vector step = vector_unit(angle_rad);
    struct vector wave = {1.0, 0.0};
    double error = 0.0;
    ASSERT(estimate->orders <= ORDERS_MAX);
    for (uint32_t place = 0; place < estimate->orders; place++) {
        wave = vector_product(wave, step);
        if (estimate->harmonic[place].seen) {
            error += estimate->harmonic[place].cosine * wave.re +
                     estimate->harmonic[place].sine * wave.im;
        }
    }
    return error;
}

double local_table_evidence(const struct application *application, const struct table_place *place,
                            const struct turn *turn) {
    const struct estimate *estimate = &application->measured;
    uint32_t counts_per_rev = (uint32_t)turn->counts_per_rev;
    double rad = 2.0 * PI / counts_per_rev;
    double arcsec = ARCSEC_PER_TURN / counts_per_rev;
    double noise = estimate->noise_arcsec;
    double variance = fmax(noise * noise * fmax(estimate->colour, 1.0), arcsec * arcsec / 12.0);
    double evidence = 0.0;
    ASSERT(counts_per_rev > 0);
    for (uint32_t sample = 0; sample < turn->samples; sample++) {
        const struct reading reading = turn_reading(turn, sample);
        double table = (local_table_value(application, place, reading.angle2, counts_per_rev) -
                        local_table_value(application, place, reading.angle1, counts_per_rev)) *
                       arcsec;
        if (table == 0.0) {
            continue;
        }
        double left =
            reading.difference * arcsec - estimate->measured_separation_rad * ARCSEC_PER_RAD;
        left -= local_table_fitted(estimate, reading.angle2 * rad) -
                local_table_fitted(estimate, reading.angle1 * rad);
        /* Log odds that the table is part of the remaining difference: (left^2 - (left - table)^2)/(2 variance) */
        evidence += table * (left - 0.5 * table) / variance;
    }
    return evidence;
}

bool local_table_write(struct application *application) {
    const struct load *load = &application->load;
    const struct core_access *core = &application->core;
    enum candidate_origin origin = application->candidate_origin;
    bool loaded = origin == OF_PENDING || (origin == OF_TURN && load_at_work(load) != NULL);
    struct load_table table = {.next = 0};
    if (origin == OF_LOAD) {
        table = load->received_table;
    } else if (origin == OF_SAVED) {
        table = application->save->content.table;
    } else if (loaded && load->table.place.choice != 0) {
        /* The loaded table is active already. */
        return true;
    }
    const struct table_place place = table.place;
    /* The registers show the choice and place of the active table, also if it became active before the firmware
       restarted after a fault. */
    bool at_work = local_table_exists(application) && core_table_place(core).choice != 0;
    if (place.choice == 0 && !at_work) {
        return true;
    }
    core_write_table_place(core, &place, application->candidate.counts_per_rev);
    const struct table_place found = core_table_place(core);
    bool equal = found.choice == place.choice;
    for (uint32_t window = 0; window < TABLE_WINDOWS; window++) {
        equal = equal && found.start[window] == place.start[window];
    }
    return equal && (place.choice == 0 || local_table_sum(application) == table.crc);
}
