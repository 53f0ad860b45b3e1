/* SPDX-License-Identifier: Apache-2.0 */

/* Receives the local table of a set: its place and its points. */

#include "crc32.h"
#include "load_frames.h"

enum { TABLE_WINDOWS_SHIFT = 4, TABLE_WIDTH_SHIFT = 8, TABLE_FRACTION_SHIFT = 12 };
enum {
    TABLE_WIDTH_MOST = 6,
    TABLE_CHOICE_BITS = 0x373F,
    POINT_MOST = 1 << (ARCTRUE_LOCAL_POINT_WIDTH - 1)
};

uint32_t load_table_windows(const struct table_place *place) {
    return 1U << (place->choice >> TABLE_WINDOWS_SHIFT & 3U);
}

uint32_t load_table_width(const struct table_place *place) {
    return place->choice >> TABLE_WIDTH_SHIFT & 7U;
}

double load_table_unit(const struct table_place *place) {
    return 1.0 / (double)(16U << 2U * (place->choice >> TABLE_FRACTION_SHIFT & 3U));
}

/* Tells whether two windows overlap or touch. Windows with the same start are allowed: only the first of them gives the
   value, the others complete the number of windows. */
static bool load_windows_overlap(const struct table_place *place, uint32_t windows,
                                 uint32_t counts_per_rev) {
    bool overlap = false;
    for (uint32_t pair = 0; pair < windows * windows; pair++) {
        uint32_t from = place->start[pair / windows];
        uint32_t to = place->start[pair % windows];
        uint32_t away = to >= from ? to - from : to + counts_per_rev - from;
        overlap = overlap ||
                  (away != 0 && (uint64_t)(away - 1) << load_table_width(place) < counts_per_rev);
    }
    return overlap;
}

bool load_table_is_valid(const struct table_place *place, uint32_t counts_per_rev) {
    uint32_t windows = load_table_windows(place);
    bool fits = (place->choice & ~(uint32_t)TABLE_CHOICE_BITS) == 0 && windows <= TABLE_WINDOWS &&
                (place->choice & 0xFU) == (1U << windows) - 1U &&
                load_table_width(place) <= TABLE_WIDTH_MOST;
    for (uint32_t window = 0; window < TABLE_WINDOWS; window++) {
        fits = fits && place->start[window] < counts_per_rev;
    }
    return fits && !load_windows_overlap(place, windows, counts_per_rev);
}

enum load_answer load_table(struct load *load, const struct table_place *place, uint32_t crc) {
    const uint32_t words[] = {place->choice, place->start[0], place->start[1], place->start[2],
                              place->start[3]};
    enum load_answer arrived =
        load_arrived(load, words, 5, crc, load->received_table.place.choice == 0);
    if (arrived != LOAD_TAKEN) {
        return arrived;
    }
    if (!load_table_is_valid(place, load->received.counts_per_rev)) {
        return load_frame_refused(load, LOAD_OUT_OF_RANGE);
    }
    load->received_table = (struct load_table){.place = *place};
    return load_frame_taken(load, words, 5);
}

static uint32_t load_step(int32_t one, int32_t other) {
    return (uint32_t)(one > other ? one - other : other - one);
}

/* Adds a point of the local table to its CRC, and updates the largest step between neighbouring points. The last point
   of a window is a neighbour of the window's first point, because the table interpolates between them. */
static void load_add_point(struct load_table *table, int32_t point) {
    uint32_t each = TABLE_POINTS / load_table_windows(&table->place);
    uint32_t in_window = table->next % each;
    uint32_t rise = in_window != 0 ? load_step(point, table->previous) : 0;
    if (in_window == 0) {
        uint32_t leap = load_step(point, 0);
        table->first = point;
        table->leap = leap > table->leap ? leap : table->leap;
    } else if (in_window == each - 1) {
        uint32_t around = load_step(point, table->first);
        rise = around > rise ? around : rise;
    }
    table->rise = rise > table->rise ? rise : table->rise;
    table->previous = point;
    table->next++;
    table->crc = crc32_add_word(table->crc, (uint32_t)point);
}

enum load_answer load_points(struct load *load, uint32_t number, const int32_t points[LOAD_POINTS],
                             uint32_t crc) {
    uint32_t words[LOAD_POINTS + 1] = {number};
    struct load_table *table = &load->received_table;
    for (uint32_t place = 0; place < LOAD_POINTS; place++) {
        words[place + 1] = (uint32_t)points[place];
    }
    enum load_answer arrived =
        load_arrived(load, words, LOAD_POINTS + 1, crc,
                     table->place.choice != 0 && number == table->next && number < TABLE_POINTS);
    if (arrived != LOAD_TAKEN) {
        return arrived;
    }
    for (uint32_t place = 0; place < LOAD_POINTS; place++) {
        bool beyond = table->next == TABLE_POINTS;
        if (points[place] < -POINT_MOST || points[place] >= POINT_MOST ||
            (beyond && points[place] != 0)) {
            return load_frame_refused(load, LOAD_OUT_OF_RANGE);
        }
        if (!beyond) {
            load_add_point(table, points[place]);
        }
    }
    return load_frame_taken(load, words, LOAD_POINTS + 1);
}

double load_table_steepest(const struct load_table *received, uint32_t counts_per_rev) {
    struct load_table table = *received;
    if (table.place.choice == 0) {
        return 0.0;
    }
    while (table.next < TABLE_POINTS) {
        load_add_point(&table, 0);
    }
    double points = TABLE_POINTS / load_table_windows(&table.place);
    uint32_t width = load_table_width(&table.place);
    double between = counts_per_rev / ((double)(1U << width) * points);
    double rise = table.rise / between;
    double leap = width != 0 ? table.leap : 0.0;
    return (rise + leap) * load_table_unit(&table.place);
}
