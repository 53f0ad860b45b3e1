/* SPDX-License-Identifier: Apache-2.0 */

/* Place of the windows of the local table in the turn. */

#ifndef ARCTRUE_TABLE_PLACE_H
#define ARCTRUE_TABLE_PLACE_H

#include <stdint.h>

enum { TABLE_POINTS = 4096, TABLE_WINDOWS = 4 };

/* Word `choice` and the first counts of the windows, as in the register map. Choice 0: no window is enabled. */
struct table_place {
    uint32_t choice;
    uint32_t start[TABLE_WINDOWS];
};

#endif
