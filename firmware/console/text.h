/* SPDX-License-Identifier: Apache-2.0 */

/* Writes numbers and words to a sink of characters, without the size and heap of printf. */

#ifndef ARCTRUE_TEXT_H
#define ARCTRUE_TEXT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef void text_put(void *context, const char *characters, size_t number);
/* Returns the number of characters that the sink accepts at once; further characters wait. */
typedef size_t text_room(void *context);

struct text_sink {
    text_put *put;
    void *context;
    /* NULL: no character ever waits. */
    text_room *room;
};

bool text_has_room(const struct text_sink *sink, size_t number);

void text_word(const struct text_sink *sink, const char *word);
/* Writes the word and a line end. */
void text_line(const struct text_sink *sink, const char *word);
/* Writes the line of an error: its text and the wrong word. */
void text_error(const struct text_sink *sink, const char *text, const char *word);
void text_unsigned(const struct text_sink *sink, uint64_t value);
/* Writes eight hexadecimal digits. */
void text_hexadecimal(const struct text_sink *sink, uint32_t value);
void text_signed(const struct text_sink *sink, int64_t value);

/* TEXT_FIXED_MOST times 1e9 fits into 64 bits. */
#define TEXT_FIXED_MOST 9e8
/* Writes 0 to 9 decimals, rounded; "null" for a number that is not finite or whose magnitude is TEXT_FIXED_MOST or
   more. */
void text_fixed(const struct text_sink *sink, double value, unsigned decimals);

/* Parses all of `word` as a decimal number of at most 15 digits without exponent. If this fails, returns false and
   leaves `value` unchanged. */
bool text_parse_decimal(const char *word, double *value);

/* Parses a whole number from -limit to limit; `limit` is at most 2^53. */
bool text_parse_whole(const char *word, double limit, int64_t *value);
/* Parses one to eight hexadecimal digits. */
bool text_parse_hexadecimal(const char *word, uint32_t *value);

bool text_equal(const char *first, const char *second);

#endif
