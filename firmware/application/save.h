/* SPDX-License-Identifier: Apache-2.0 */

/* Records in a region of the flash, each in a sector of its own, written in turn, a piece at a time:
   power that is lost at any moment of a write leaves the record before, and nothing waits for the flash.
   A sector that does not take what is written is left out. */

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
    /* The flash was silent at the start; what it holds was read only now and is not in use. */
    SAVE_NOT_READ_AT_START,
    /* The record holds more orders than would be kept, and nobody asked for that. */
    SAVE_FEWER,
    SAVE_ANSWERS,
};

struct save {
    struct flash_access flash;
    /* The region of the records, from its beginning on; bytes. */
    uint32_t address;
    uint32_t bytes;
    uint32_t sector_bytes;
    enum save_state state;
    /* How the last one ended, where `fresh` says that nobody was told yet. */
    enum save_answer answer;
    bool fresh;
    /* The latest whole record, its sector and its number; where there is none, why not. */
    enum saved_answer found;
    uint32_t latest;
    uint32_t sequence;
    /* The highest number that any record has, or that one was written with and not confirmed. */
    uint32_t highest;
    /* The sector that is written, or was last; how many this save has tried; a bit for each that did not
       take what was written since the start. */
    uint32_t sector;
    uint32_t tries;
    uint32_t worn;
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

/* Nothing is read yet. The region is `bytes` long: at least two sectors, at most 32 of them are used. */
void save_prepare(struct save *save, const struct flash_access *flash, uint32_t address,
                  uint32_t bytes);

/* The latest of the records that are whole, into `content`. False: there is none, or, where `found` is
   SAVED_UNREAD, the flash does not answer. */
bool save_find(struct save *save);

/* SAVE_DONE: the records are known, and one more may be written. Where the flash was silent before they
   are looked for; a record that is found then is not in use, and is answered once. */
enum save_answer save_look_again(struct save *save);

/* What `content` holds, where nothing is under way. SAVE_DONE: it has begun. A save never shrinks what
   is kept without being asked: `least` lanes there must be, 0 where the operator asked for less. */
enum save_answer save_begin(struct save *save, uint32_t least);

/* Sectors that did not take what was written since the start. */
uint32_t save_worn(const struct save *save);

/* A piece of what is under way. */
void save_step(struct save *save);

#endif
