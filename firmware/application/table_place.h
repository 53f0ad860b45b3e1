/* SPDX-License-Identifier: Apache-2.0 */

/* Declares where the windows of the local table lie in the turn. A local table holds points of the correction, between
   which the gateware interpolates in each window. */

#ifndef ARCTRUE_TABLE_PLACE_H
#define ARCTRUE_TABLE_PLACE_H

#include <stdbool.h>
#include <stdint.h>

#include "arctrue_number_formats.h"

enum { TABLE_POINTS = 1 << ARCTRUE_LOCAL_INDEX_WIDTH, TABLE_WINDOWS = ARCTRUE_LOCAL_WINDOWS };

/* Word `choice` and the first count of each window, as in the register map. Choice 0: no window is enabled. */
struct table_place {
    uint32_t choice;
    uint32_t start[TABLE_WINDOWS];
};

enum { LOAD_POINTS = 5 };

/* A local table; the gateware holds its points. */
struct load_table {
    struct table_place place;
    /* Number of the next point, and CRC of the points so far. */
    uint32_t next;
    uint32_t crc;
    /* The first point of the present window; the previous point; the largest step between neighbours (`rise`); and the
       largest step from 0 to the first point of a window (`leap`); all in units of a point. */
    int32_t first;
    int32_t previous;
    uint32_t rise;
    uint32_t leap;
};

/* Tells whether the words are within their ranges. */
bool load_table_is_valid(const struct table_place *place, uint32_t counts_per_rev);
/* Returns the number of windows. */
uint32_t load_table_windows(const struct table_place *place);
/* Returns w; the width of a window is 2^-w turn. */
uint32_t load_table_width(const struct table_place *place);
/* Returns the unit of a point in counts. */
double load_table_unit(const struct table_place *place);

#endif
