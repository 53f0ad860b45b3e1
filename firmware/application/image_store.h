/* SPDX-License-Identifier: Apache-2.0 */

/* Writes boot images into the flash, one line of the console at a time.

   The boot ROM starts the first image that it finds: it searches for a header every 32 KB from the beginning on
   (UG585, chapter 6, "BootROM header search") and stores the place of the header in MULTIBOOT_ADDR. The first image
   can be updated. The golden image follows it and is never written again once it is whole. An update overwrites the
   signature of the first image before it erases the sectors, and writes the header last: so a loss of power does no
   harm, even during an erase. */

#ifndef ARCTRUE_IMAGE_STORE_H
#define ARCTRUE_IMAGE_STORE_H

#include <stdbool.h>
#include <stdint.h>

#include "flash_access.h"

/* Largest number of words that one command writes. */
enum { IMAGE_WORDS_MOST = 6 };
/* Largest number of bytes per CRC command: their CRC takes 50 ms. */
#define IMAGE_CHECKED_MOST 0x10000U

/* Offsets in bytes from the beginning of the flash. */
struct image_map {
    uint32_t golden;
    uint32_t golden_bytes;
    /* End of the part of the flash that holds images. */
    uint32_t end;
};

enum image_answer {
    IMAGE_DONE,
    IMAGE_NO_FLASH,
    IMAGE_UNDER_WAY,
    /* The range lies outside the area for images, crosses a page, is empty or too long, or is no multiple of a word. */
    IMAGE_PLACE,
    /* The golden image is complete, because its header, which is written last, is valid; so it is not overwritten. */
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
    /* Operation in progress, and the words to compare after its end; an erase has no words. */
    bool busy;
    uint32_t address;
    uint32_t number;
    uint32_t words[IMAGE_WORDS_MOST];
    /* Result of the last operation; `fresh`: it has not been reported yet. */
    enum image_answer answer;
    bool fresh;
};

const char *image_answer_name(enum image_answer answer);

void image_store_prepare(struct image_store *store, const struct flash_access *flash,
                         const struct image_map *map);

/* Returns IMAGE_GOLDEN_STAYS if the golden image has a header that the boot ROM would accept, IMAGE_DONE if it has none;
   another answer if the flash cannot be read, for example during an operation. */
enum image_answer image_store_golden(struct image_store *store);

/* These functions begin an operation of the flash. They return IMAGE_DONE if the operation has begun. */
enum image_answer image_store_erase(struct image_store *store, uint32_t address);
enum image_answer image_store_write(struct image_store *store, uint32_t address,
                                    const uint32_t *words, uint32_t number);

/* Computes the CRC-32 of `bytes` bytes from `address` on. */
enum image_answer image_store_check(struct image_store *store, uint32_t address, uint32_t bytes,
                                    uint32_t *crc);

/* If the operation in progress has ended, compares the written words with the flash and stores the result. */
void image_store_step(struct image_store *store);

#endif
