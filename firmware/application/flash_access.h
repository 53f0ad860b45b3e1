/* SPDX-License-Identifier: Apache-2.0 */

/* A flash over functions, so that what is stored in it can be tested without one. Addresses are
   bytes from its beginning, multiples of 4. */

#ifndef ARCTRUE_FLASH_ACCESS_H
#define ARCTRUE_FLASH_ACCESS_H

#include <stdbool.h>
#include <stdint.h>

/* Words that are programmed at once, within a page. */
enum { FLASH_PAGE_WORDS = 64 };

enum flash_activity {
    FLASH_IDLE,
    FLASH_AT_WORK,
    /* It does not end. */
    FLASH_STUCK,
};

/* Bytes that are erased at once; 0: no flash answers, or one that is not known. Call it before
   the first of the others, and again when others have used the flash. */
typedef uint32_t flash_access_open(void *context);
/* False: the controller does not answer. */
typedef bool flash_access_read(void *context, uint32_t address, uint32_t *words, uint32_t number);
/* These begin something, which flash_access_activity tells the end of; false as above. */
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
