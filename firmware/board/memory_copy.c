/* SPDX-License-Identifier: Apache-2.0 */

/* Provides memcpy() for the compiler's copies of structures. The library's memcpy() takes 1.2 KB, because it is made
   for speed, which is not needed here. */

#include <stddef.h>
#include <stdint.h>

void *memcpy(void *restrict to, const void *restrict from, size_t bytes);

/* Without this attribute the compiler replaces the loops by a call of memcpy(). */
__attribute__((optimize("no-tree-loop-distribute-patterns"))) void *
memcpy(void *restrict to, const void *restrict from, size_t bytes) {
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
