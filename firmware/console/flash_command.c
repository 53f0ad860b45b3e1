/* SPDX-License-Identifier: Apache-2.0 */

#include "flash_command.h"

#include <stddef.h>

#include "crc32.h"

const char flash_use[] =
    "flash status | flash erase ADDRESS | flash data ADDRESS WORDS CRC | flash "
    "check ADDRESS BYTES: arctrue flash sends these lines";

enum { DIGITS_A_WORD = 8 };

static void print_answer(const struct console *console, enum image_answer answer) {
    if (answer == IMAGE_DONE) {
        text_line(&console->sink, "ok");
        return;
    }
    text_error(&console->sink, "flash ", image_answer_name(answer));
}

/* Prints the answer if the operation has not begun. If it has begun, flash_step_reported() prints the answer when the
   operation has ended. */
static void begun(const struct console *console, enum image_answer answer) {
    if (answer != IMAGE_DONE) {
        print_answer(console, answer);
    }
}

/* Parses words of eight hexadecimal digits and returns their number; 0 if the text does not consist of such words or
   has too many. */
static uint32_t read_words(char *digits, uint32_t words[IMAGE_WORDS_MOST]) {
    uint32_t number = 0;
    while (*digits != '\0') {
        char one[DIGITS_A_WORD + 1] = {0};
        for (uint32_t place = 0; place < DIGITS_A_WORD && *digits != '\0'; place++) {
            one[place] = *digits++;
        }
        if (number == IMAGE_WORDS_MOST || one[DIGITS_A_WORD - 1] == '\0' ||
            !text_parse_hexadecimal(one, &words[number++])) {
            return 0;
        }
    }
    return number;
}

static void data(const struct console *console, struct image_store *store, char *const *words) {
    uint32_t address;
    uint32_t content[IMAGE_WORDS_MOST];
    uint32_t crc;
    uint32_t number = read_words(words[1], content);
    bool read = number != 0 && text_parse_hexadecimal(words[0], &address) &&
                text_parse_hexadecimal(words[2], &crc);
    uint32_t found = read ? crc32_add_word(0, address) : 0;
    for (uint32_t place = 0; read && place < number; place++) {
        found = crc32_add_word(found, content[place]);
    }
    if (!read || found != crc) {
        text_line(&console->sink, "error: flash wrong_crc");
        return;
    }
    begun(console, image_store_write(store, address, content, number));
}

static void status(const struct console *console, struct image_store *store) {
    enum image_answer golden = image_store_golden(store);
    if (golden == IMAGE_UNDER_WAY || golden == IMAGE_NO_ANSWER) {
        print_answer(console, golden);
        return;
    }
    text_line(&console->sink, golden == IMAGE_GOLDEN_STAYS ? "golden whole" : "golden none");
    text_word(&console->sink, "sector_bytes ");
    text_unsigned(&console->sink, store->sector_bytes);
    text_word(&console->sink, "\r\nstarted_from 0x");
    text_hexadecimal(&console->sink, console->started_from);
    text_line(&console->sink, "\r\nok");
}

static void check_image(const struct console *console, struct image_store *store,
                        char *const *words) {
    uint32_t address;
    uint32_t bytes;
    uint32_t crc = 0;
    if (!text_parse_hexadecimal(words[0], &address) || !text_parse_hexadecimal(words[1], &bytes)) {
        print_answer(console, IMAGE_PLACE);
        return;
    }
    enum image_answer answer = image_store_check(store, address, bytes, &crc);
    if (answer == IMAGE_DONE) {
        text_word(&console->sink, "crc ");
        text_hexadecimal(&console->sink, crc);
        text_line(&console->sink, "");
    }
    print_answer(console, answer);
}

void flash_command(struct console *console, char *const *words, uint32_t number) {
    struct image_store *store = console->images;
    const struct save *save = console->application->save;
    const char *what = words[1];
    uint32_t address;
    if (store == NULL) {
        print_answer(console, IMAGE_NO_FLASH);
    } else if (save != NULL && save->state != SAVE_IDLE) {
        print_answer(console, IMAGE_UNDER_WAY);
    } else if (text_equal(what, "status") && number == 2) {
        status(console, store);
    } else if (text_equal(what, "erase") && number == 3 &&
               text_parse_hexadecimal(words[2], &address)) {
        begun(console, image_store_erase(store, address));
    } else if (text_equal(what, "data") && number == 5) {
        data(console, store, words + 2);
    } else if (text_equal(what, "check") && number == 4) {
        check_image(console, store, words + 2);
    } else {
        text_error(&console->sink, "use: ", flash_use);
    }
}

void flash_step_reported(struct console *console) {
    struct image_store *store = console->images;
    if (store == NULL) {
        return;
    }
    image_store_step(store);
    if (store->fresh) {
        store->fresh = false;
        print_answer(console, store->answer);
    }
}
