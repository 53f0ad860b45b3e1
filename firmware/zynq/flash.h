/* SPDX-License-Identifier: Apache-2.0 */

/* Accesses the serial flash through the quad-SPI controller, with commands on one wire (UG585, chapter 12: I/O
   mode). fabric.c reads the same flash as memory. */

#ifndef ARCTRUE_ZYNQ_FLASH_H
#define ARCTRUE_ZYNQ_FLASH_H

#include "flash_access.h"
#include "register_access.h"

struct flash {
    struct register_access access;
    /* JEDEC ID: maker, kind and size, in three bytes, the maker in the most significant byte. */
    uint32_t id;
    uint32_t sector_bytes;
    /* Time at which the present erase or programming began. */
    uint32_t since_us;
    uint32_t most_us;
};

/* Connects the controller to the flash's pins; nothing is read or written yet. */
void flash_prepare(struct flash *flash, const struct register_access *access);

/* Functions of flash_access.h; the context is a struct flash. */
uint32_t flash_open(void *context);
bool flash_read(void *context, uint32_t address, uint32_t *words, uint32_t number);
bool flash_erase(void *context, uint32_t address);
bool flash_program(void *context, uint32_t address, const uint32_t *words, uint32_t number);
enum flash_activity flash_activity(void *context);

struct flash_access flash_access_to(struct flash *flash);

#endif
