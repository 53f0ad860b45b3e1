/* SPDX-License-Identifier: Apache-2.0 */

/* Provides the functions on memory and texts that the firmware calls, and that the compiler calls to copy structures.
   The library's versions take 1.9 KB, because they are faster than the firmware needs. */

#include <stddef.h>
#include <stdint.h>
#include <string.h>

/* Without this attribute the compiler replaces the loops by calls of the functions that contain them. */
#define OWN_LOOPS __attribute__((optimize("no-tree-loop-distribute-patterns")))

OWN_LOOPS void *memcpy(void *restrict to, const void *restrict from, size_t bytes) {
    unsigned char *byte_to = to;
    const unsigned char *byte_from = from;
    if ((((uintptr_t)to | (uintptr_t)from) & (sizeof(uint32_t) - 1)) == 0) {
        uint32_t *word_to = to;
        const uint32_t *word_from = from;
        for (; bytes >= sizeof(uint32_t); bytes -= sizeof(uint32_t)) {
            *word_to++ = *word_from++;
        }
        byte_to = (unsigned char *)word_to;
        byte_from = (const unsigned char *)word_from;
    }
    for (; bytes > 0; bytes--) {
        *byte_to++ = *byte_from++;
    }
    return to;
}

OWN_LOOPS void *memset(void *to, int value, size_t bytes) {
    unsigned char *byte_to = to;
    if (((uintptr_t)to & (sizeof(uint32_t) - 1)) == 0) {
        uint32_t *word_to = to;
        const uint32_t word = (unsigned char)value * 0x01010101U;
        /* heads_residual.c clears its columns for each sample, so four words are written at a time. */
        for (; bytes >= 4 * sizeof(uint32_t); bytes -= 4 * sizeof(uint32_t), word_to += 4) {
            word_to[0] = word;
            word_to[1] = word;
            word_to[2] = word;
            word_to[3] = word;
        }
        for (; bytes >= sizeof(uint32_t); bytes -= sizeof(uint32_t)) {
            *word_to++ = word;
        }
        byte_to = (unsigned char *)word_to;
    }
    for (; bytes > 0; bytes--) {
        *byte_to++ = (unsigned char)value;
    }
    return to;
}

OWN_LOOPS int memcmp(const void *first, const void *second, size_t bytes) {
    const unsigned char *a = first;
    const unsigned char *b = second;
    for (; bytes > 0 && *a == *b; bytes--) {
        a++;
        b++;
    }
    return bytes > 0 ? *a - *b : 0;
}

OWN_LOOPS size_t strlen(const char *text) {
    size_t length = 0;
    while (text[length] != '\0') {
        length++;
    }
    return length;
}

OWN_LOOPS int strncmp(const char *first, const char *second, size_t most) {
    const unsigned char *a = (const unsigned char *)first;
    const unsigned char *b = (const unsigned char *)second;
    for (; most > 0 && *a == *b && *a != 0; most--) {
        a++;
        b++;
    }
    return most > 0 ? *a - *b : 0;
}
