/* SPDX-License-Identifier: Apache-2.0 */

/* Two records in a flash, written in turn, a piece at a time: power that is lost at any moment of
   a write leaves the record before, and nothing waits for the flash. */

#ifndef ARCTRUE_SAVE_H
#define ARCTRUE_SAVE_H

#include <stdbool.h>
#include <stdint.h>

#include "flash_access.h"
#include "saved.h"

enum save_state {
    SAVE_IDLE,
    SAVE_ERASING,
    SAVE_PROGRAMMING,
    SAVE_READING_BACK,
};

enum save_answer {
    SAVE_DONE,
    SAVE_NO_FLASH,
    SAVE_UNDER_WAY,
    SAVE_NO_ANSWER,
    SAVE_STUCK,
    SAVE_NOT_ERASED,
    SAVE_NOT_READ_BACK,
    /* The record holds more orders than would be kept, and nobody asked for that. */
    SAVE_FEWER,
    SAVE_ANSWERS,
};

struct save {
    struct flash_access flash;
    /* Where the first record is; the second is `apart` bytes further. */
    uint32_t address;
    uint32_t apart;
    enum save_state state;
    /* How the last one ended, where `fresh` says that nobody was told yet. */
    enum save_answer answer;
    bool fresh;
    /* The later whole record, and which of both it is; where there is none, why not. */
    enum saved_answer found;
    uint32_t latest;
    uint32_t sequence;
    /* Lanes of that record, and of which table they are; 0: there is none. */
    uint32_t kept_lanes;
    uint32_t kept_counts_per_rev;
    struct saved content;
    /* The record on its way to the flash or from there. */
    uint32_t place;
    uint32_t number;
    uint32_t words[SAVED_WORDS_MOST];
};

const char *save_answer_name(enum save_answer answer);

/* Nothing is read yet. The two records have `apart` bytes each, at least a sector. */
void save_prepare(struct save *save, const struct flash_access *flash, uint32_t address,
                  uint32_t apart);

/* The later of the records that are whole, into `content`. False: there is none. */
bool save_find(struct save *save);

/* What `content` holds, where nothing is under way. SAVE_DONE: it has begun. A save never shrinks what
   is kept without being asked: `least` lanes there must be, 0 where the operator asked for less. */
enum save_answer save_begin(struct save *save, uint32_t least);

/* A piece of what is under way. */
void save_step(struct save *save);

#endif
