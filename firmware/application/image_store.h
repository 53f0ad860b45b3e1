/* SPDX-License-Identifier: Apache-2.0 */

/* Writes boot images into the flash, a line of the console at a time.

   The boot ROM starts the first image that it finds: it looks for a header every 32 KB from the beginning
   on (UG585, chapter 6, "BootROM header search"), and leaves where it found it in MULTIBOOT_ADDR. The first place is the image
   that is updated; after it lies the golden one, which is never written again once it is whole. Where the
   signature of the first image is overwritten before its sectors are erased, and its header is written last,
   power may be lost at any moment, in the middle of an erase too. */

#ifndef ARCTRUE_IMAGE_STORE_H
#define ARCTRUE_IMAGE_STORE_H

#include <stdbool.h>
#include <stdint.h>

#include "flash_access.h"

/* Words that are written at once. */
enum { IMAGE_WORDS_MOST = 6 };
/* Bytes whose CRC is told at once: it takes 50 ms. */
#define IMAGE_CHECKED_MOST 0x10000U

/* Bytes from the flash's beginning. */
struct image_map {
    uint32_t golden;
    uint32_t golden_bytes;
    /* From here on the flash is not for images. */
    uint32_t end;
};

enum image_answer {
    IMAGE_DONE,
    IMAGE_NO_FLASH,
    IMAGE_UNDER_WAY,
    /* Outside of what is for images, across a page, or no multiple of a word. */
    IMAGE_PLACE,
    /* The golden image is whole and stays. */
    IMAGE_GOLDEN_STAYS,
    IMAGE_NO_ANSWER,
    IMAGE_STUCK,
    IMAGE_NOT_READ_BACK,
    IMAGE_ANSWERS,
};

struct image_store {
    struct flash_access flash;
    struct image_map map;
    uint32_t sector_bytes;
    /* Under way: what is read back when it has ended; no words: an erase. */
    bool busy;
    uint32_t address;
    uint32_t number;
    uint32_t words[IMAGE_WORDS_MOST];
    /* How it ended, where `fresh` says that nobody was told yet. */
    enum image_answer answer;
    bool fresh;
};

const char *image_answer_name(enum image_answer answer);

void image_store_prepare(struct image_store *store, const struct flash_access *flash,
                         const struct image_map *map);

/* A header that the boot ROM would take. */
bool image_store_has_golden(struct image_store *store);

/* Each begins something and takes the flash for it; IMAGE_DONE: it has begun. */
enum image_answer image_store_erase(struct image_store *store, uint32_t address);
enum image_answer image_store_write(struct image_store *store, uint32_t address,
                                    const uint32_t *words, uint32_t number);

/* CRC-32 of `bytes` from `address` on. */
enum image_answer image_store_check(struct image_store *store, uint32_t address, uint32_t bytes,
                                    uint32_t *crc);

/* A look at what is under way. */
void image_store_step(struct image_store *store);

#endif
