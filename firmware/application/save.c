/* SPDX-License-Identifier: Apache-2.0 */

#include "save.h"

#include <stddef.h>
#include <string.h>

#include "assertion.h"

enum { WORD_BYTES = 4, SECTORS_LEAST = 2, SECTORS_MOST = 32 };
/* Largest number of sectors that one save tries: a failing erase may take 3 s, and the operator waits. */
enum { TRIES_MOST = 4 };
#define ERASED 0xFFFFFFFFU

const char *save_answer_name(enum save_answer answer) {
    static const char *const names[SAVE_ANSWERS] = {
        [SAVE_DONE] = "done",
        [SAVE_NO_FLASH] = "flash_unknown",
        [SAVE_UNDER_WAY] = "under_way",
        [SAVE_NO_ANSWER] = "flash_silent",
        [SAVE_STUCK] = "flash_stuck",
        [SAVE_NOT_ERASED] = "flash_not_erased",
        [SAVE_NOT_READ_BACK] = "flash_not_read_back",
        [SAVE_NOT_READ_AT_START] = "not_read_at_start",
        [SAVE_FEWER] = "fewer_orders",
        [SAVE_TABLE_NOT_HELD] = "table_not_held",
    };
    return (unsigned)answer < SAVE_ANSWERS ? names[answer] : "unknown";
}

void save_prepare(struct save *save, const struct flash_access *flash, uint32_t address,
                  uint32_t bytes) {
    memset(save, 0, sizeof *save);
    save->flash = *flash;
    save->address = address;
    save->bytes = bytes;
    save->found = SAVED_UNREAD;
}

static uint32_t save_sectors(const struct save *save) {
    ASSERT(save->sector_bytes > 0);
    uint32_t sectors = save->bytes / save->sector_bytes;
    return sectors < SECTORS_MOST ? sectors : SECTORS_MOST;
}

static uint32_t save_sector_address(const struct save *save, uint32_t sector) {
    ASSERT(sector < SECTORS_MOST);
    return save->address + sector * save->sector_bytes;
}

/* Returns false if the flash does not answer, or if its sectors are too small or too few. */
static bool save_open_flash(struct save *save) {
    uint32_t sector_bytes = save->flash.open(save->flash.context);
    if (sector_bytes < SAVED_WORDS_MOST * WORD_BYTES) {
        return false;
    }
    save->sector_bytes = sector_bytes;
    return save_sectors(save) >= SECTORS_LEAST;
}

/* Tells whether a sector has room for the points of a local table. */
static bool save_has_room(const struct save *save) {
    return save->sector_bytes >= (SAVE_POINTS_AT + TABLE_POINTS) * WORD_BYTES;
}

static bool save_is_later(uint32_t sequence, uint32_t than) {
    return (int32_t)(sequence - than) > 0;
}

static bool save_has_number(enum saved_answer answer) {
    return answer == SAVED_READ || answer == SAVED_OTHER_VERSION || answer == SAVED_OUT_OF_RANGE;
}

static bool save_read_sector(struct save *save, uint32_t sector) {
    return save->flash.read(save->flash.context, save_sector_address(save, sector), save->words,
                            SAVED_WORDS_MOST);
}

/* Notes a whole record as the latest record unless a later one was found. Until a whole record is found, notes the
   fault of the first sector that is not empty. */
static void save_note_record(struct save *save, uint32_t sector, enum saved_answer answer,
                             uint32_t sequence) {
    if (answer == SAVED_READ &&
        (save->found != SAVED_READ || save_is_later(sequence, save->sequence))) {
        save->found = SAVED_READ;
        save->latest = sector;
        save->sequence = sequence;
    } else if (save->found == SAVED_EMPTY) {
        save->found = answer;
    }
}

/* Notes the properties of the latest whole record. */
static void save_note_kept(struct save *save) {
    save->kept_lanes = saved_lanes(&save->content);
    save->kept_counts_per_rev = save->content.own.counts_per_rev;
}

/* Reads all records. The next record gets the number after the highest number of any record, even of a record of
   another version. */
static bool save_read_all(struct save *save) {
    bool numbered = false;
    save->found = SAVED_EMPTY;
    save->highest = 0;
    save->sector = save_sectors(save) - 1;
    for (uint32_t sector = 0; sector < save_sectors(save); sector++) {
        uint32_t sequence = 0;
        if (!save_read_sector(save, sector)) {
            return false;
        }
        enum saved_answer answer = saved_read(save->words, &save->content, &sequence);
        save_note_record(save, sector, answer, sequence);
        if (save_has_number(answer) && (!numbered || save_is_later(sequence, save->highest))) {
            numbered = true;
            save->highest = sequence;
            save->sector = sector;
        }
    }
    return true;
}

static bool save_read_latest(struct save *save) {
    uint32_t sequence;
    return save_read_sector(save, save->latest) &&
           saved_read(save->words, &save->content, &sequence) == SAVED_READ;
}

/* Reads the latest record a second time, because there is memory for one record only. It opens the flash a second time
   after reading all records, because a flash that has become silent meanwhile would read as empty. */
bool save_find(struct save *save) {
    bool whole = save_open_flash(save) && save_read_all(save) && save_open_flash(save);
    if (whole && save->found == SAVED_READ) {
        whole = save_read_latest(save);
    }
    if (!whole) {
        save->found = SAVED_UNREAD;
    }
    if (save->found == SAVED_READ) {
        save_note_kept(save);
    }
    return save->found == SAVED_READ;
}

enum save_answer save_look_again(struct save *save) {
    if (save->found != SAVED_UNREAD) {
        return save_open_flash(save) ? SAVE_DONE : SAVE_NO_FLASH;
    }
    if (save_find(save)) {
        return SAVE_NOT_READ_AT_START;
    }
    return save->found == SAVED_UNREAD ? SAVE_NO_FLASH : SAVE_DONE;
}

void save_take_back(struct save *save) {
    if (save->found == SAVED_READ) {
        (void)save_read_latest(save);
    }
}

uint32_t save_worn(const struct save *save) {
    uint32_t number = 0;
    for (uint32_t left = save->worn; left != 0; left &= left - 1) {
        number++;
    }
    return number;
}

static void save_end(struct save *save, enum save_answer answer) {
    save->state = SAVE_IDLE;
    save->answer = answer;
    save->fresh = true;
}

/* Chooses the next sector in turn, but never the sector of the latest whole record. */
static bool save_choose_sector(struct save *save) {
    uint32_t sectors = save_sectors(save);
    for (uint32_t step = 1; step <= sectors; step++) {
        uint32_t sector = (save->sector + step) % sectors;
        bool taken = save->found == SAVED_READ && sector == save->latest;
        if (!taken && (save->worn >> sector & 1U) == 0) {
            save->sector = sector;
            return true;
        }
    }
    return false;
}

/* Fills the record and begins to erase the chosen sector. Each try gets a new record number, because the record of a
   failed try may nevertheless be whole. */
static enum save_answer save_erase_sector(struct save *save) {
    save->number = saved_write(&save->content, ++save->highest, save->words);
    save->points = save->content.table.place.choice != 0 ? TABLE_POINTS : 0;
    ASSERT(save->points == 0 || save->point != NULL);
    save->place = 0;
    if (!save->flash.erase(save->flash.context, save_sector_address(save, save->sector))) {
        return SAVE_NO_ANSWER;
    }
    save->state = SAVE_ERASING;
    return SAVE_DONE;
}

enum save_answer save_begin(struct save *save, uint32_t least) {
    ASSERT(save->state == SAVE_IDLE);
    if (saved_lanes(&save->content) < least) {
        return SAVE_FEWER;
    }
    bool has_points = save->content.table.place.choice != 0;
    if (save->found == SAVED_UNREAD || !save_open_flash(save) ||
        (has_points && !save_has_room(save))) {
        return SAVE_NO_FLASH;
    }
    save->fresh = false;
    save->tries = 1;
    if (!save_choose_sector(save)) {
        /* All sectors failed: the flash may have been protected, so all are tried again. */
        save->worn = 0;
        (void)save_choose_sector(save);
    }
    return save_erase_sector(save);
}

/* Marks the sector as worn and begins to write the record into another sector. If no sector or no try is left, the save
   ends with `answer`. */
static void save_leave_out(struct save *save, enum save_answer answer) {
    save->worn |= 1U << save->sector;
    if (save->tries == TRIES_MOST || !save_choose_sector(save)) {
        save_end(save, answer);
        return;
    }
    save->tries++;
    if (save_erase_sector(save) != SAVE_DONE) {
        save_end(save, SAVE_NO_ANSWER);
    }
}

static void save_go_on_or_end(struct save *save, enum save_answer answer) {
    if (answer == SAVE_NOT_ERASED || answer == SAVE_NOT_READ_BACK) {
        save_leave_out(save, answer);
    } else {
        save_end(save, answer);
    }
}

/* Returns the address of the page at `place`, and sets the number of its words and the words. */
static uint32_t save_page(const struct save *save, uint32_t place, uint32_t *number,
                          uint32_t words[FLASH_PAGE_WORDS]) {
    uint32_t address = save_sector_address(save, save->sector);
    bool of_points = place < save->points;
    uint32_t first = of_points ? place : place - save->points;
    uint32_t left = (of_points ? save->points : save->number) - first;
    *number = left < FLASH_PAGE_WORDS ? left : FLASH_PAGE_WORDS;
    for (uint32_t word = 0; word < *number; word++) {
        words[word] = of_points ? (uint32_t)save->point(save->point_context, first + word)
                                : save->words[first + word];
    }
    return address + (first + (of_points ? SAVE_POINTS_AT : 0U)) * WORD_BYTES;
}

/* Compares all pages with their intended content or, before programming (which can only clear bits), with an erased
   flash. */
static enum save_answer save_compare(struct save *save, bool is_erased) {
    uint32_t words[FLASH_PAGE_WORDS];
    uint32_t found[FLASH_PAGE_WORDS];
    uint32_t number;
    for (uint32_t place = 0; place < save->points + save->number; place += number) {
        uint32_t address = save_page(save, place, &number, words);
        if (!save->flash.read(save->flash.context, address, found, FLASH_PAGE_WORDS)) {
            return SAVE_NO_ANSWER;
        }
        for (uint32_t word = 0; word < (is_erased ? FLASH_PAGE_WORDS : number); word++) {
            if (found[word] != (is_erased ? ERASED : words[word])) {
                return is_erased ? SAVE_NOT_ERASED : SAVE_NOT_READ_BACK;
            }
        }
    }
    return SAVE_DONE;
}

static void save_program_page(struct save *save) {
    uint32_t words[FLASH_PAGE_WORDS];
    uint32_t number;
    uint32_t address = save_page(save, save->place, &number, words);
    if (!save->flash.program(save->flash.context, address, words, number)) {
        save_end(save, SAVE_NO_ANSWER);
        return;
    }
    save->place += number;
    save->state = save->place < save->points + save->number ? SAVE_PROGRAMMING : SAVE_READING_BACK;
}

bool save_read_points(struct save *save, uint32_t first, uint32_t words[FLASH_PAGE_WORDS]) {
    ASSERT(first + FLASH_PAGE_WORDS <= TABLE_POINTS);
    return save->found == SAVED_READ && save->flash.read(save->flash.context,
                                                         save_sector_address(save, save->latest) +
                                                             (SAVE_POINTS_AT + first) * WORD_BYTES,
                                                         words, FLASH_PAGE_WORDS);
}

static void save_read_back(struct save *save) {
    enum save_answer answer = save_compare(save, false);
    if (answer == SAVE_DONE) {
        save->latest = save->sector;
        save->sequence = save->highest;
        save->found = SAVED_READ;
        save_note_kept(save);
    }
    save_go_on_or_end(save, answer);
}

void save_step(struct save *save) {
    ASSERT((unsigned)save->state <= SAVE_READING_BACK);
    ASSERT(save->number <= SAVED_WORDS_MOST && save->place <= save->points + save->number);
    if (save->state == SAVE_IDLE) {
        return;
    }
    enum flash_activity activity = save->flash.activity(save->flash.context);
    if (activity == FLASH_STUCK) {
        save_end(save, SAVE_STUCK);
    }
    if (activity != FLASH_IDLE) {
        return;
    }
    if (save->state == SAVE_READING_BACK) {
        save_read_back(save);
        return;
    }
    enum save_answer answer = save->state == SAVE_ERASING ? save_compare(save, true) : SAVE_DONE;
    if (answer == SAVE_DONE) {
        save_program_page(save);
    } else {
        save_go_on_or_end(save, answer);
    }
}
