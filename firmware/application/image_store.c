/* SPDX-License-Identifier: Apache-2.0 */

#include "image_store.h"

#include "crc32.h"

#define WORD_BYTES 4U
#define PAGE_BYTES (FLASH_PAGE_WORDS * WORD_BYTES)
/* Offset, in the header of a boot image, of the part that the header's checksum covers. This part begins with the width
   detection word; the checksum follows it (UG585, chapter 6). */
#define HEADER_CHECKED 0x20U
#define HEADER_WIDTH_DETECTION 0xAA995566U
#define HEADER_SIGNATURE 0x584C4E58U
enum { HEADER_WORDS = 11 };

const char *image_answer_name(enum image_answer answer) {
    static const char *const names[] = {
        [IMAGE_DONE] = "done",
        [IMAGE_NO_FLASH] = "flash_unknown",
        [IMAGE_UNDER_WAY] = "under_way",
        [IMAGE_PLACE] = "wrong_place",
        [IMAGE_GOLDEN_STAYS] = "golden_stays",
        [IMAGE_NO_ANSWER] = "flash_silent",
        [IMAGE_STUCK] = "flash_stuck",
        [IMAGE_NOT_READ_BACK] = "flash_not_read_back",
    };
    return (unsigned)answer < IMAGE_ANSWERS ? names[answer] : "unknown";
}

void image_store_prepare(struct image_store *store, const struct flash_access *flash,
                         const struct image_map *map) {
    *store = (struct image_store){.flash = *flash, .map = *map};
}

static bool image_is_header(const uint32_t words[HEADER_WORDS]) {
    uint32_t sum = 0;
    for (uint32_t place = 0; place + 1 < HEADER_WORDS; place++) {
        sum += words[place];
    }
    return words[0] == HEADER_WIDTH_DETECTION && words[1] == HEADER_SIGNATURE &&
           words[HEADER_WORDS - 1] == ~sum;
}

static enum image_answer image_take_flash(struct image_store *store) {
    if (store->busy) {
        return IMAGE_UNDER_WAY;
    }
    store->sector_bytes = store->flash.open(store->flash.context);
    return store->sector_bytes != 0 ? IMAGE_DONE : IMAGE_NO_FLASH;
}

enum image_answer image_store_golden(struct image_store *store) {
    uint32_t words[HEADER_WORDS];
    enum image_answer answer = image_take_flash(store);
    if (answer != IMAGE_DONE) {
        return answer;
    }
    if (!store->flash.read(store->flash.context, store->map.golden + HEADER_CHECKED, words,
                           HEADER_WORDS)) {
        return IMAGE_NO_ANSWER;
    }
    return image_is_header(words) ? IMAGE_GOLDEN_STAYS : IMAGE_DONE;
}

static enum image_answer image_may_change(struct image_store *store, uint32_t first,
                                          uint32_t bytes) {
    const struct image_map *map = &store->map;
    if (first % WORD_BYTES != 0 || first >= map->end || bytes > map->end - first) {
        return IMAGE_PLACE;
    }
    bool touches = first < map->golden + map->golden_bytes && first + bytes > map->golden;
    return touches ? image_store_golden(store) : IMAGE_DONE;
}

static enum image_answer image_begun(struct image_store *store, bool answers, uint32_t address,
                                     uint32_t number) {
    store->busy = answers;
    store->address = address;
    store->number = number;
    return answers ? IMAGE_DONE : IMAGE_NO_ANSWER;
}

enum image_answer image_store_erase(struct image_store *store, uint32_t address) {
    enum image_answer answer = image_take_flash(store);
    if (answer != IMAGE_DONE) {
        return answer;
    }
    uint32_t first = address - address % store->sector_bytes;
    answer = image_may_change(store, first, store->sector_bytes);
    if (answer != IMAGE_DONE) {
        return answer;
    }
    return image_begun(store, store->flash.erase(store->flash.context, first), first, 0);
}

enum image_answer image_store_write(struct image_store *store, uint32_t address,
                                    const uint32_t *words, uint32_t number) {
    enum image_answer answer = image_take_flash(store);
    if (answer == IMAGE_DONE) {
        answer = image_may_change(store, address, number * WORD_BYTES);
    }
    if (answer != IMAGE_DONE) {
        return answer;
    }
    if (number == 0 || number > IMAGE_WORDS_MOST ||
        address % PAGE_BYTES + number * WORD_BYTES > PAGE_BYTES) {
        return IMAGE_PLACE;
    }
    for (uint32_t place = 0; place < number; place++) {
        store->words[place] = words[place];
    }
    return image_begun(store, store->flash.program(store->flash.context, address, words, number),
                       address, number);
}

enum image_answer image_store_check(struct image_store *store, uint32_t address, uint32_t bytes,
                                    uint32_t *crc) {
    enum image_answer answer = image_take_flash(store);
    if (answer != IMAGE_DONE) {
        return answer;
    }
    if (address % WORD_BYTES != 0 || bytes % WORD_BYTES != 0 || bytes > IMAGE_CHECKED_MOST ||
        address >= store->map.end || bytes > store->map.end - address) {
        return IMAGE_PLACE;
    }
    *crc = 0;
    for (uint32_t place = 0; place < bytes; place += WORD_BYTES) {
        uint32_t word;
        if (!store->flash.read(store->flash.context, address + place, &word, 1)) {
            return IMAGE_NO_ANSWER;
        }
        *crc = crc32_add_word(*crc, word);
    }
    return IMAGE_DONE;
}

static enum image_answer image_read_back(const struct image_store *store) {
    uint32_t words[IMAGE_WORDS_MOST];
    if (!store->flash.read(store->flash.context, store->address, words, store->number)) {
        return IMAGE_NO_ANSWER;
    }
    for (uint32_t place = 0; place < store->number; place++) {
        if (words[place] != store->words[place]) {
            return IMAGE_NOT_READ_BACK;
        }
    }
    return IMAGE_DONE;
}

void image_store_step(struct image_store *store) {
    if (!store->busy) {
        return;
    }
    enum flash_activity activity = store->flash.activity(store->flash.context);
    if (activity == FLASH_AT_WORK) {
        return;
    }
    store->busy = false;
    store->fresh = true;
    store->answer = activity == FLASH_STUCK ? IMAGE_STUCK : image_read_back(store);
}
