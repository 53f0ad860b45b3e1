/* SPDX-License-Identifier: Apache-2.0 */

/* Defines the map of the flash, in bytes from its beginning. */

#ifndef ARCTRUE_FLASH_MAP_H
#define ARCTRUE_FLASH_MAP_H

/* The boot image that can be updated is at the beginning; the golden image, which is never written again once it is
   whole, follows it. The boot ROM searches for an image every 32 KB. Each has 256 KB, the largest sector size of the
   known flashes. */
#define FLASH_MAP_GOLDEN 0x00040000U
#define FLASH_MAP_GOLDEN_BYTES 0x00040000U
/* The bitstream follows both images; see fabric_image.h. */
#define FLASH_MAP_BITSTREAM 0x00100000U
#define FLASH_MAP_BITSTREAM_BYTES 0x00E00000U
/* The records of saved data fill the flash from here to its end, each in a sector of its own (save.h). */
#define FLASH_MAP_RECORDS 0x00F00000U
#define FLASH_MAP_RECORDS_BYTES 0x00100000U

#endif
