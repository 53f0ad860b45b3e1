/* SPDX-License-Identifier: Apache-2.0 */

#include "fabric_image.h"

#include <stdbool.h>

enum { MAGIC_WORD = 0, VERSION_WORD = 1, LENGTH_WORD = 2, CRC_WORD = 3, WORD_BYTES = 4 };

static uint32_t word_at(const struct register_access *access, uint32_t address, uint32_t word) {
    return access->read(access->context, address + WORD_BYTES * word);
}

static bool has_sync_word(const struct register_access *access, const struct fabric_image *image) {
    uint32_t words = image->length / WORD_BYTES;
    for (uint32_t word = 0; word < words && word < FABRIC_IMAGE_SYNC_WITHIN; word++) {
        if (word_at(access, image->address, word) == FABRIC_IMAGE_SYNC_WORD) {
            return true;
        }
    }
    return false;
}

enum fabric_image_answer fabric_image_read(const struct register_access *access, uint32_t address,
                                           struct fabric_image *image) {
    *image = (struct fabric_image){
        .address = address + FABRIC_IMAGE_HEADER_BYTES,
        .length = word_at(access, address, LENGTH_WORD),
        .crc = word_at(access, address, CRC_WORD),
    };
    if (word_at(access, address, MAGIC_WORD) != FABRIC_IMAGE_MAGIC) {
        return FABRIC_IMAGE_ABSENT;
    }
    if (word_at(access, address, VERSION_WORD) != FABRIC_IMAGE_VERSION) {
        return FABRIC_IMAGE_OTHER_VERSION;
    }
    if (image->length == 0 || image->length > FABRIC_IMAGE_LENGTH_MOST ||
        image->length % WORD_BYTES != 0) {
        return FABRIC_IMAGE_BAD_LENGTH;
    }
    return has_sync_word(access, image) ? FABRIC_IMAGE_FOUND : FABRIC_IMAGE_NO_SYNC_WORD;
}
