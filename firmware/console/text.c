/* SPDX-License-Identifier: Apache-2.0 */

#include "text.h"

#include <math.h>
#include <string.h>

#include "assertion.h"

enum { DIGITS_MOST = 20, DECIMALS_MOST = 9, HEXADECIMAL_DIGITS = 8 };
/* Largest whole number up to which a double holds every whole number, 2^53. */
#define WHOLE_MOST 9007199254740992.0
/* Number of decimal digits that a double can hold. */
enum { PARSED_DIGITS_MOST = 15 };

bool text_has_room(const struct text_sink *sink, size_t number) {
    return sink->room == NULL || sink->room(sink->context) >= number;
}

void text_word(const struct text_sink *sink, const char *word) {
    ASSERT(word != NULL);
    sink->put(sink->context, word, strlen(word));
}

void text_line(const struct text_sink *sink, const char *word) {
    text_word(sink, word);
    text_word(sink, "\r\n");
}

void text_error(const struct text_sink *sink, const char *text, const char *word) {
    text_word(sink, "error: ");
    text_word(sink, text);
    text_line(sink, word);
}

static void digits(const struct text_sink *sink, uint64_t value, unsigned least) {
    char text[DIGITS_MOST];
    unsigned first = DIGITS_MOST;
    while (value != 0 || DIGITS_MOST - first < least) {
        text[--first] = (char)('0' + value % 10);
        value /= 10;
    }
    sink->put(sink->context, text + first, DIGITS_MOST - first);
}

void text_unsigned(const struct text_sink *sink, uint64_t value) {
    digits(sink, value, 1);
}

void text_hexadecimal(const struct text_sink *sink, uint32_t value) {
    char text[HEXADECIMAL_DIGITS];
    for (unsigned place = HEXADECIMAL_DIGITS; place-- > 0; value >>= 4) {
        text[place] = "0123456789ABCDEF"[value & 15U];
    }
    sink->put(sink->context, text, HEXADECIMAL_DIGITS);
}

void text_signed(const struct text_sink *sink, int64_t value) {
    if (value < 0) {
        text_word(sink, "-");
    }
    digits(sink, value < 0 ? 0U - (uint64_t)value : (uint64_t)value, 1);
}

void text_fixed(const struct text_sink *sink, double value, unsigned decimals) {
    ASSERT(decimals <= DECIMALS_MOST);
    uint64_t scale = 1;
    for (unsigned place = 0; place < decimals; place++) {
        scale *= 10;
    }
    /* The negated comparison is also true for a value that is not a number. */
    if (!(fabs(value) < TEXT_FIXED_MOST)) {
        text_word(sink, "null");
        return;
    }
    uint64_t scaled = (uint64_t)(fabs(value) * (double)scale + 0.5);
    if (value < 0.0 && scaled != 0) {
        text_word(sink, "-");
    }
    digits(sink, scaled / scale, 1);
    if (decimals > 0) {
        text_word(sink, ".");
        digits(sink, scaled % scale, decimals);
    }
}

static bool is_digit(char character) {
    return character >= '0' && character <= '9';
}

bool text_parse_decimal(const char *word, double *value) {
    bool negative = *word == '-';
    const char *next = word + (*word == '-' || *word == '+');
    double magnitude = 0.0;
    double divisor = 1.0;
    bool fraction = false;
    unsigned number = 0;
    for (; is_digit(*next) || (*next == '.' && !fraction); next++) {
        if (*next == '.') {
            fraction = true;
            continue;
        }
        magnitude = magnitude * 10.0 + (*next - '0');
        divisor *= fraction ? 10.0 : 1.0;
        number++;
    }
    if (*next != '\0' || number == 0 || number > PARSED_DIGITS_MOST) {
        return false;
    }
    *value = (negative ? -magnitude : magnitude) / divisor;
    return true;
}

bool text_parse_whole(const char *word, double limit, int64_t *value) {
    ASSERT(limit >= 0.0 && limit <= WHOLE_MOST);
    double number;
    if (!text_parse_decimal(word, &number) || number != floor(number) || fabs(number) > limit) {
        return false;
    }
    *value = (int64_t)number;
    return true;
}

static int hexadecimal_digit(char character) {
    if (is_digit(character)) {
        return character - '0';
    }
    if (character >= 'a' && character <= 'f') {
        return character - 'a' + 10;
    }
    return character >= 'A' && character <= 'F' ? character - 'A' + 10 : -1;
}

bool text_parse_hexadecimal(const char *word, uint32_t *value) {
    uint32_t number = 0;
    size_t length = strlen(word);
    if (length == 0 || length > HEXADECIMAL_DIGITS) {
        return false;
    }
    for (; *word != '\0'; word++) {
        int digit = hexadecimal_digit(*word);
        if (digit < 0) {
            return false;
        }
        number = number << 4 | (uint32_t)digit;
    }
    *value = number;
    return true;
}

bool text_equal(const char *first, const char *second) {
    /* This loop takes less memory than the library's strcmp(). */
    while (*first != '\0' && *first == *second) {
        first++;
        second++;
    }
    return *first == *second;
}
