/* SPDX-License-Identifier: Apache-2.0 */

#ifndef ARCTRUE_CRC32_H
#define ARCTRUE_CRC32_H

#include <stdint.h>

/* Adds a little-endian word to a CRC-32 of IEEE 802.3, as zlib and gzip compute it. Begin with 0; the result of one
   word is the start value for the next. */
uint32_t crc32_add_word(uint32_t crc, uint32_t word);

#endif
