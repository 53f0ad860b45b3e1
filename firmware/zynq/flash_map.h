/* SPDX-License-Identifier: Apache-2.0 */

/* What lies where in the flash, bytes from its beginning. */

#ifndef ARCTRUE_FLASH_MAP_H
#define ARCTRUE_FLASH_MAP_H

/* The boot image that is updated, at the beginning; the golden one after it, which stays: the boot ROM
   looks for one every 32 KB. Each has 256 KB, the largest sector of the flashes that are known. */
#define FLASH_MAP_GOLDEN 0x00040000U
#define FLASH_MAP_GOLDEN_BYTES 0x00040000U
/* The bitstream is after both; fabric_image.h. */
#define FLASH_MAP_BITSTREAM 0x00100000U
#define FLASH_MAP_BITSTREAM_BYTES 0x00E00000U
/* Records of what was saved: from here to the end of the flash, each in a sector of its own (save.h). */
#define FLASH_MAP_RECORDS 0x00F00000U
#define FLASH_MAP_RECORDS_BYTES 0x00100000U

#endif
