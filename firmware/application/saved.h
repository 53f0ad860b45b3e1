/* SPDX-License-Identifier: Apache-2.0 */

/* Converts the data that `save` stores, settings and coefficients, to and from the words of a record.

   Little-endian words:
     0  magic, "ATSV"
     1  version of this form, 1
     2  sequence number; a later record has a greater number, modulo 2^32
     3  number of words of the content
     4  switches: frozen 1, bypassed 2, telemetry 4, 8 if lanes follow a condition, 16 if there are sets for a
        missing head, 32 if there is a local table, and 64 if there are lanes of real orders
     then the number of parameters, and for each: check sum of its name, value as a double in two
     words, the lower first
     then counts_per_rev, the number of lanes, and for each: order, phase offset, amplitude, owner
     (0 the calibration, 1 loaded, 2 loaded, but confirmed by no turn)
     then, with switch 16: the number of words of the sets for a missing head, and these words; kept_sets.h
     then, with switch 8: the number of lanes that follow a condition, width, dead zone and nominal speed, and
     for each: modulator, order, phase offset, amplitude; followed.h
     then, with switch 64: the number of lanes of real orders, and for each: order, turn step (the lower word first),
     amplitude, source of the phase, side, probe phase; real_lanes.h
     then, with switch 32: choice and four starts of the local table, and the CRC of its points, which stand in the
     same sector; save.h
     then the number of loaded lanes that follow the temperature, T0 in 0.001 degC, the time constant in ms, and for
     each: order, cosine and sine of c1, cosine and sine of c2; thermal.h
     then, if such lanes exist and their range of temperature is not the preset one: its limits in 0.001 degC
     then, if the loaded lanes correct a mean: heads, carrier, used heads, constant part of the error, delays, and
     for each of four heads: weight, offset; mean_set.h
     last  CRC-32 of all words before */

#ifndef ARCTRUE_SAVED_H
#define ARCTRUE_SAVED_H

#include <stdbool.h>
#include <stdint.h>

#include "coefficients.h"
#include "followed.h"
#include "kept_sets.h"
#include "kept_settings.h"
#include "table_place.h"
#include "thermal.h"

#define SAVED_MAGIC 0x56535441U
#define SAVED_VERSION 1U
enum { SAVED_HEAD_WORDS = 4, SAVED_PARAMETERS_MOST = 64 };
enum {
    SAVED_LANE_WORDS = 4,
    SAVED_PARAMETER_WORDS = 3,
    SAVED_THERMAL_WORDS = 5,
    SAVED_CONDITIONS_WORDS = 4,
    SAVED_REAL_WORDS = 7,
    SAVED_MEAN_WORDS = 5 + 2 * HEADS_MOST,
    SAVED_TABLE_WORDS = 2 + TABLE_WINDOWS,
    SAVED_WORDS_MOST = SAVED_HEAD_WORDS + 2 + SAVED_PARAMETERS_MOST * SAVED_PARAMETER_WORDS + 2 +
        LANES_LIMIT * SAVED_LANE_WORDS + 3 + THERMAL_LANES_MAX * SAVED_THERMAL_WORDS + 2 +
        SAVED_MEAN_WORDS + 1 + KEPT_SETS_WORDS + SAVED_CONDITIONS_WORDS +
        FOLLOWED_LANES_MAX * SAVED_LANE_WORDS + 1 + REAL_LANES_MAX * SAVED_REAL_WORDS +
        SAVED_TABLE_WORDS + 1,
};

struct saved {
    struct settings settings;
    /* Coefficients of the calibration, and coefficients that the operator loaded. */
    struct coefficients own;
    struct coefficients loaded;
    struct thermal thermal;
    struct followed followed;
    /* Sets for a missing head that belong to the loaded mean. */
    struct kept_sets sets;
    /* Place and check sum of the local table; choice 0: none. */
    struct load_table table;
    /* Loaded lanes that no turn has judged, one bit per lane. */
    uint64_t unjudged;
};

enum saved_answer {
    SAVED_READ,
    /* The first word is erased, so the sector holds no record. */
    SAVED_EMPTY,
    /* The record was not written to its end, or has changed since. */
    SAVED_DAMAGED,
    SAVED_OTHER_VERSION,
    SAVED_OUT_OF_RANGE,
    /* The flash does not answer, so its content is not known. */
    SAVED_UNREAD,
    SAVED_ANSWERS,
};

const char *saved_answer_name(enum saved_answer answer);

/* Writes the words of the record, at most SAVED_WORDS_MOST, and returns their number. */
uint32_t saved_write(const struct saved *saved, uint32_t sequence, uint32_t *words);

/* Reads a record from `words`, of which SAVED_WORDS_MOST exist. `sequence` is set if the check sum is right. A
   parameter that the record does not have gets its preset; a parameter that this firmware does not know is ignored.
   `saved` may change even if the record is refused. */
enum saved_answer saved_read(const uint32_t *words, struct saved *saved, uint32_t *sequence);

/* Returns the number of used lanes of both owners (calibration and operator), of lanes that follow a condition, and of
   lanes of real orders. */
uint32_t saved_lanes(const struct saved *saved);

#endif
