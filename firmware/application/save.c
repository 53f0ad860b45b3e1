/* SPDX-License-Identifier: Apache-2.0 */

#include "save.h"

#include <string.h>

enum { RECORDS = 2, WORD_BYTES = 4 };
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
        [SAVE_FEWER] = "fewer_orders",
    };
    return (unsigned)answer < SAVE_ANSWERS ? names[answer] : "unknown";
}

void save_prepare(struct save *save, const struct flash_access *flash, uint32_t address,
                  uint32_t apart) {
    memset(save, 0, sizeof *save);
    save->flash = *flash;
    save->address = address;
    save->apart = apart;
    save->found = SAVED_EMPTY;
}

static uint32_t address_of(const struct save *save, uint32_t record) {
    return save->address + record * save->apart;
}

static bool open(struct save *save) {
    uint32_t sector_bytes = save->flash.open(save->flash.context);
    return sector_bytes != 0 && sector_bytes <= save->apart;
}

static enum saved_answer read(struct save *save, uint32_t record, uint32_t *sequence) {
    if (!save->flash.read(save->flash.context, address_of(save, record), save->words,
                          SAVED_WORDS_MOST)) {
        return SAVED_EMPTY;
    }
    return saved_read(save->words, &save->content, sequence);
}

/* Of the record that is the later whole one. */
static void note_kept(struct save *save) {
    save->kept_lanes = saved_lanes(&save->content);
    save->kept_counts_per_rev = save->content.own.counts_per_rev;
}

/* The first record is read again where it is the later one: there is room for one. */
bool save_find(struct save *save) {
    uint32_t sequence[RECORDS] = {0, 0};
    enum saved_answer found[RECORDS];
    save->found = SAVED_EMPTY;
    if (!open(save)) {
        return false;
    }
    for (uint32_t record = 0; record < RECORDS; record++) {
        found[record] = read(save, record, &sequence[record]);
    }
    bool both = found[0] == SAVED_READ && found[1] == SAVED_READ;
    if (both) {
        save->latest = (int32_t)(sequence[1] - sequence[0]) > 0;
    } else {
        save->latest = found[1] == SAVED_READ;
    }
    if (save->latest == 0) {
        found[0] = read(save, 0, &sequence[0]);
    }
    save->sequence = sequence[save->latest];
    save->found = found[save->latest] == SAVED_EMPTY ? found[1] : found[save->latest];
    if (save->found == SAVED_READ) {
        note_kept(save);
    }
    return save->found == SAVED_READ;
}

static void end(struct save *save, enum save_answer answer) {
    save->state = SAVE_IDLE;
    save->answer = answer;
    save->fresh = true;
}

/* The record that is not the later whole one: where none is whole, either. */
static uint32_t next_record(const struct save *save) {
    return save->found == SAVED_READ ? 1U - save->latest : 0U;
}

enum save_answer save_begin(struct save *save, uint32_t least) {
    if (saved_lanes(&save->content) < least) {
        return SAVE_FEWER;
    }
    if (!open(save)) {
        return SAVE_NO_FLASH;
    }
    save->fresh = false;
    save->number = saved_write(&save->content, save->sequence + 1, save->words);
    save->place = 0;
    if (!save->flash.erase(save->flash.context, address_of(save, next_record(save)))) {
        return SAVE_NO_ANSWER;
    }
    save->state = SAVE_ERASING;
    return SAVE_DONE;
}

/* Programming clears bits and sets none. */
static enum save_answer look_erased(struct save *save) {
    uint32_t words[FLASH_PAGE_WORDS];
    uint32_t address = address_of(save, next_record(save));
    for (uint32_t place = 0; place < save->number; place += FLASH_PAGE_WORDS) {
        if (!save->flash.read(save->flash.context, address + place * WORD_BYTES, words,
                              FLASH_PAGE_WORDS)) {
            return SAVE_NO_ANSWER;
        }
        for (uint32_t word = 0; word < FLASH_PAGE_WORDS; word++) {
            if (words[word] != ERASED) {
                return SAVE_NOT_ERASED;
            }
        }
    }
    return SAVE_DONE;
}

static void program_page(struct save *save) {
    uint32_t left = save->number - save->place;
    uint32_t number = left < FLASH_PAGE_WORDS ? left : FLASH_PAGE_WORDS;
    uint32_t address = address_of(save, next_record(save)) + save->place * WORD_BYTES;
    if (!save->flash.program(save->flash.context, address, save->words + save->place, number)) {
        end(save, SAVE_NO_ANSWER);
        return;
    }
    save->place += number;
    save->state = save->place < save->number ? SAVE_PROGRAMMING : SAVE_READING_BACK;
}

static enum save_answer compare(struct save *save) {
    uint32_t words[FLASH_PAGE_WORDS];
    uint32_t address = address_of(save, next_record(save));
    for (uint32_t place = 0; place < save->number; place++) {
        uint32_t word = place % FLASH_PAGE_WORDS;
        if (word == 0 && !save->flash.read(save->flash.context, address + place * WORD_BYTES,
                                           words, FLASH_PAGE_WORDS)) {
            return SAVE_NO_ANSWER;
        }
        if (words[word] != save->words[place]) {
            return SAVE_NOT_READ_BACK;
        }
    }
    return SAVE_DONE;
}

static void read_back(struct save *save) {
    enum save_answer answer = compare(save);
    if (answer == SAVE_DONE) {
        save->latest = next_record(save);
        save->sequence++;
        save->found = SAVED_READ;
        note_kept(save);
    }
    end(save, answer);
}

void save_step(struct save *save) {
    if (save->state == SAVE_IDLE) {
        return;
    }
    enum flash_activity activity = save->flash.activity(save->flash.context);
    if (activity == FLASH_STUCK) {
        end(save, SAVE_STUCK);
    }
    if (activity != FLASH_IDLE) {
        return;
    }
    if (save->state == SAVE_READING_BACK) {
        read_back(save);
        return;
    }
    enum save_answer answer = save->state == SAVE_ERASING ? look_erased(save) : SAVE_DONE;
    if (answer == SAVE_DONE) {
        program_page(save);
    } else {
        end(save, answer);
    }
}
