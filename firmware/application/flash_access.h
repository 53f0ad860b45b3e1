/* SPDX-License-Identifier: Apache-2.0 */

/* Declares the functions through which the storage accesses a flash, so that the storage can be tested without a flash.
   Addresses are bytes from the beginning of the flash, multiples of 4. */

#ifndef ARCTRUE_FLASH_ACCESS_H
#define ARCTRUE_FLASH_ACCESS_H

#include <stdbool.h>
#include <stdint.h>

/* Largest number of words that one command programs; they must lie in one page. */
enum { FLASH_PAGE_WORDS = 64 };

enum flash_activity {
    FLASH_IDLE,
    FLASH_AT_WORK,
    /* The operation does not end. */
    FLASH_STUCK,
};

/* Returns the number of bytes that one command erases; 0: no known flash answers. Call it before all other functions,
   and again after other code has used the flash. */
typedef uint32_t flash_access_open(void *context);
/* Reads words. Returns false if the controller does not answer. */
typedef bool flash_access_read(void *context, uint32_t address, uint32_t *words, uint32_t number);
/* These functions begin an operation; flash_access_activity reports its end. They return false if the controller does
   not answer. */
typedef bool flash_access_erase(void *context, uint32_t address);
typedef bool flash_access_program(void *context, uint32_t address, const uint32_t *words,
                                  uint32_t number);
typedef enum flash_activity flash_access_activity(void *context);

struct flash_access {
    flash_access_open *open;
    flash_access_read *read;
    flash_access_erase *erase;
    flash_access_program *program;
    flash_access_activity *activity;
    void *context;
};

#endif
