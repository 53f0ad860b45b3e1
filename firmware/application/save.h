/* SPDX-License-Identifier: Apache-2.0 */

/* Writes records into a region of the flash: each record into the next sector, one piece per call. If power is lost at
   any moment of a write, the previous record remains. No function waits for the end of an erase or of a programming. A
   sector that fails to erase or differs from the written data is skipped until the next start, or until all sectors
   have failed. */

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
    /* The flash was silent at the start. Its content has only now been read and is not in use. */
    SAVE_NOT_READ_AT_START,
    /* The latest record holds more orders than the new record would hold, and the operator has not allowed fewer. */
    SAVE_FEWER,
    /* Neither the gateware nor the latest record holds the points of the local table. */
    SAVE_TABLE_NOT_HELD,
    SAVE_ANSWERS,
};

/* Offset, in words, of the local table's points from the start of the record's sector. The processor's memory does not
   hold the points. They are written before the record, so that a complete record always has complete points. */
enum { SAVE_POINTS_AT = 2048 };
/* Returns point `number` while the record is written. */
typedef int32_t save_point(const void *context, uint32_t number);

struct save {
    struct flash_access flash;
    save_point *point;
    const void *point_context;
    /* Region of the records: offset and length in bytes. */
    uint32_t address;
    uint32_t bytes;
    uint32_t sector_bytes;
    enum save_state state;
    /* Result of the last save; `fresh`: it has not been reported yet. */
    enum save_answer answer;
    bool fresh;
    /* `found`: SAVED_READ if a record is whole, otherwise the reason why none is. `latest` and `sequence`: sector and
       number of the latest whole record. */
    enum saved_answer found;
    uint32_t latest;
    uint32_t sequence;
    /* The highest number of any record, or of a write that was not confirmed. */
    uint32_t highest;
    /* Sector that is being written or was written last; number of sectors that this save has tried; one bit for each
       sector that failed since the start. */
    uint32_t sector;
    uint32_t tries;
    uint32_t worn;
    /* Number of lanes of the latest whole record, and its counts per turn; 0: there is no record. */
    uint32_t kept_lanes;
    uint32_t kept_counts_per_rev;
    struct saved content;
    /* The record that is being written or read: `place` counts its points, if it has any, and then its words. */
    uint32_t points;
    uint32_t place;
    uint32_t number;
    uint32_t words[SAVED_WORDS_MOST];
};

const char *save_answer_name(enum save_answer answer);

/* Sets the region; nothing is read yet. The region is `bytes` long. It has at least two sectors, of which at most 32
   are used. */
void save_prepare(struct save *save, const struct flash_access *flash, uint32_t address,
                  uint32_t bytes);

/* Reads the latest whole record into `content`. Returns false if there is none or, with `found` SAVED_UNREAD, if the
   flash does not answer. */
bool save_find(struct save *save);

/* Searches the records if the flash was silent before. Returns SAVE_DONE if the records are known and another record
   may be written, SAVE_NO_FLASH if the flash is silent. Returns SAVE_NOT_READ_AT_START once if it finds a record
   only now, because that record is not in use. */
enum save_answer save_look_again(struct save *save);

/* Reads the latest whole record, if there is one, into `content` again, after a changed content was refused. */
void save_take_back(struct save *save);

/* Begins to write `content`; no save may be in progress (the function asserts this). Returns SAVE_DONE if the write has
   begun. Returns SAVE_FEWER if the content has fewer than `least` lanes, so that no save drops lanes by mistake;
   `least` is 0 if the operator allows fewer lanes. */
enum save_answer save_begin(struct save *save, uint32_t least);

/* Reads points of the latest record, from point `first` on. Returns false if there is no whole record or the flash does
   not answer. */
bool save_read_points(struct save *save, uint32_t first, uint32_t words[FLASH_PAGE_WORDS]);

/* Returns the number of sectors that failed since the start. */
uint32_t save_worn(const struct save *save);

/* Does a piece of the save in progress. */
void save_step(struct save *save);

#endif
