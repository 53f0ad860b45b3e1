/* SPDX-License-Identifier: Apache-2.0 */

/* Defines the map of the flash, in bytes from its beginning. */

#ifndef ARCTRUE_FLASH_MAP_H
#define ARCTRUE_FLASH_MAP_H

/* Offset of the golden image, which is never written again once it is whole. The boot image that can be updated lies
   before it, at the beginning. The boot ROM searches for an image every 32 KB. The space for each image has 256 KB, the
   largest sector size of the known flashes. */
#define FLASH_MAP_GOLDEN 0x00040000U
#define FLASH_MAP_GOLDEN_BYTES 0x00040000U
/* Offset of the bitstream, after both images; see fabric_image.h. */
#define FLASH_MAP_BITSTREAM 0x00100000U
#define FLASH_MAP_BITSTREAM_BYTES 0x00E00000U
/* Offset of the records of saved data, which fill the flash from here to its end, each in a sector of its own
   (save.h). */
#define FLASH_MAP_RECORDS 0x00F00000U
#define FLASH_MAP_RECORDS_BYTES 0x00100000U

#endif
