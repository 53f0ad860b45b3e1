/* SPDX-License-Identifier: Apache-2.0 */

/* Numbers and words to a sink of characters, without printf's size and heap. */

#ifndef ARCTRUE_TEXT_H
#define ARCTRUE_TEXT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef void text_put(void *context, const char *characters, size_t number);
/* Characters that are taken at once; what is put beyond them waits. */
typedef size_t text_room(void *context);

struct text_sink {
    text_put *put;
    void *context;
    /* NULL: nothing ever waits. */
    text_room *room;
};

bool text_has_room(const struct text_sink *sink, size_t number);

void text_word(const struct text_sink *sink, const char *word);
/* The word and the end of its line. */
void text_line(const struct text_sink *sink, const char *word);
/* The line of an error: what is wrong, and the word that is. */
void text_error(const struct text_sink *sink, const char *text, const char *word);
void text_unsigned(const struct text_sink *sink, uint64_t value);
/* Eight digits. */
void text_hexadecimal(const struct text_sink *sink, uint32_t value);
void text_signed(const struct text_sink *sink, int64_t value);

/* With 0 to 9 decimals, rounded; "null" for what is not finite or above 9e8. */
void text_fixed(const struct text_sink *sink, double value, unsigned decimals);

/* A decimal number, all of `word`; no exponent. False leaves `value` as it was. */
bool text_parse_decimal(const char *word, double *value);

/* A whole number within -limit and limit, both at most 2^53. */
bool text_parse_whole(const char *word, double limit, int64_t *value);
/* One to eight hexadecimal digits. */
bool text_parse_hexadecimal(const char *word, uint32_t *value);

bool text_equal(const char *first, const char *second);

#endif
