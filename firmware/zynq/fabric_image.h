/* SPDX-License-Identifier: Apache-2.0 */

/* Reads the header of the fabric's bitstream in the flash: 64 bytes, which the bitstream follows.

   Little-endian words:
     0  magic, "ATBS"
     1  version of this header, 1
     2  length of the bitstream in bytes, a multiple of 4
     3  CRC-32 (IEEE 802.3, as zlib.crc32) of the bitstream
     4 to 15  unused, 0
   The bitstream is a raw .bin without the text header of a .bit. The bytes of each word are swapped to the
   order that the configuration port expects: read as a word, the synchronisation word is 0xAA995566. */

#ifndef ARCTRUE_FABRIC_IMAGE_H
#define ARCTRUE_FABRIC_IMAGE_H

#include <stdint.h>

#include "flash_map.h"
#include "register_access.h"

#define FABRIC_IMAGE_MAGIC 0x53425441U
#define FABRIC_IMAGE_VERSION 1U
#define FABRIC_IMAGE_HEADER_BYTES 64U
/* Largest length; the bitstream of the XC7Z020 has 4,045,564 bytes. */
#define FABRIC_IMAGE_LENGTH_MOST (FLASH_MAP_BITSTREAM_BYTES - FABRIC_IMAGE_HEADER_BYTES)
#define FABRIC_IMAGE_SYNC_WORD 0xAA995566U
/* Number of first words among which the synchronisation word must be. */
#define FABRIC_IMAGE_SYNC_WITHIN 64U

struct fabric_image {
    /* Address of the bitstream's first word. */
    uint32_t address;
    uint32_t length;
    uint32_t crc;
};

enum fabric_image_answer {
    FABRIC_IMAGE_FOUND,
    FABRIC_IMAGE_ABSENT,
    FABRIC_IMAGE_OTHER_VERSION,
    FABRIC_IMAGE_BAD_LENGTH,
    FABRIC_IMAGE_NO_SYNC_WORD,
};

/* Reads the header at `address`. It does not check the CRC, because that takes a second. */
enum fabric_image_answer fabric_image_read(const struct register_access *access, uint32_t address,
                                           struct fabric_image *image);

#endif
