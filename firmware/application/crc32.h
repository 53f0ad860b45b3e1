/* SPDX-License-Identifier: Apache-2.0 */

#ifndef ARCTRUE_CRC32_H
#define ARCTRUE_CRC32_H

#include <stdint.h>

/* CRC-32 of IEEE 802.3, as zlib and gzip compute it, over little-endian words. Begin with 0; the result of one piece
   is the start value of the next. */
uint32_t crc32_add_word(uint32_t crc, uint32_t word);

#endif
