/* SPDX-License-Identifier: Apache-2.0 */

/* Uses any bytes as the two records of the flash; two bits of the first byte select the records that get a correct head
   and check sum. Accepted parameters must be values that the console would accept, and an accepted record that is
   written and read again must have the same words. */

#include <stdlib.h>
#include <string.h>

#include "crc32.h"
#include "fuzz_target.h"
#include "save.h"

enum { LENGTH_WORD = 3, FIRST_FITS = 1, SECOND_FITS = 2 };

static struct {
    struct save save;
    struct save again;
    uint32_t flash[2][SAVED_WORDS_MOST];
} fuzz;

static void require(bool holds) {
    if (!holds) {
        abort();
    }
}

static uint32_t open(void *context) {
    (void)context;
    return sizeof fuzz.flash[0];
}

static bool read(void *context, uint32_t address, uint32_t *words, uint32_t number) {
    (void)context;
    require(address % 4 == 0);
    for (uint32_t word = 0; word < number; word++) {
        uint32_t place = address / 4 + word;
        words[word] = place < 2 * SAVED_WORDS_MOST ? (&fuzz.flash[0][0])[place] : 0xFFFFFFFFU;
    }
    return true;
}

static void fit(uint32_t *record) {
    uint32_t length = record[LENGTH_WORD] % (SAVED_WORDS_MOST - SAVED_HEAD_WORDS);
    uint32_t crc = 0;
    record[0] = SAVED_MAGIC;
    record[1] = SAVED_VERSION;
    record[LENGTH_WORD] = length;
    for (uint32_t word = 0; word < SAVED_HEAD_WORDS + length; word++) {
        crc = crc32_add_word(crc, record[word]);
    }
    record[SAVED_HEAD_WORDS + length] = crc;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    const struct flash_access flash = {.open = open, .read = read};
    memset(&fuzz, 0, sizeof fuzz);
    memset(fuzz.flash, 0xFF, sizeof fuzz.flash);
    if (size == 0) {
        return 0;
    }
    size_t bytes = size - 1 < sizeof fuzz.flash ? size - 1 : sizeof fuzz.flash;
    memcpy(fuzz.flash, data + 1, bytes);
    if (data[0] & FIRST_FITS) {
        fit(fuzz.flash[0]);
    }
    if (data[0] & SECOND_FITS) {
        fit(fuzz.flash[1]);
    }
    save_prepare(&fuzz.save, &flash, 0, sizeof fuzz.flash);
    if (!save_find(&fuzz.save)) {
        require(fuzz.save.found != SAVED_READ);
        return 0;
    }
    const struct saved *saved = &fuzz.save.content;
    require(parameters_are_valid(&saved->settings.parameters));
    require(saved_lanes(saved) <= LANES_LIMIT && thermal_is_valid(&saved->thermal));
    /* The accepted record is written and read again. */
    memset(fuzz.flash, 0xFF, sizeof fuzz.flash);
    uint32_t number = saved_write(saved, fuzz.save.sequence, fuzz.flash[0]);
    save_prepare(&fuzz.again, &flash, 0, sizeof fuzz.flash);
    require(save_find(&fuzz.again) && fuzz.again.sequence == fuzz.save.sequence);
    require(saved_write(&fuzz.again.content, fuzz.again.sequence, fuzz.flash[1]) == number);
    require(memcmp(fuzz.flash[0], fuzz.flash[1], sizeof fuzz.flash[0]) == 0);
    return 0;
}
