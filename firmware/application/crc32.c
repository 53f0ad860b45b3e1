/* SPDX-License-Identifier: Apache-2.0 */

#include "crc32.h"

enum { NIBBLES_A_WORD = 8 };

uint32_t crc32_add_word(uint32_t crc, uint32_t word) {
    /* The polynomial 0x04C11DB7, reflected, for each value of four bits. */
    static const uint32_t table[16] = {
        0x00000000U, 0x1DB71064U, 0x3B6E20C8U, 0x26D930ACU, 0x76DC4190U, 0x6B6B51F4U,
        0x4DB26158U, 0x5005713CU, 0xEDB88320U, 0xF00F9344U, 0xD6D6A3E8U, 0xCB61B38CU,
        0x9B64C2B0U, 0x86D3D2D4U, 0xA00AE278U, 0xBDBDF21CU,
    };
    crc = ~crc ^ word;
    for (unsigned nibble = 0; nibble < NIBBLES_A_WORD; nibble++) {
        crc = crc >> 4 ^ table[crc & 15U];
    }
    return ~crc;
}
