/* SPDX-License-Identifier: Apache-2.0 */

/* Declares the functions with which the caller reads and writes the registers of the gateware (the core): they access
   memory on the device, a simulator's bus, or a model on the host. */

#ifndef ARCTRUE_CORE_ACCESS_H
#define ARCTRUE_CORE_ACCESS_H

#include <stdint.h>

typedef uint32_t core_read_word(void *context, uint32_t offset);
typedef void core_write_word(void *context, uint32_t offset, uint32_t word);
/* Returns `number` words of the ready bank; they do not change until the bank is released. */
typedef const volatile int32_t *core_capture_words(void *context, uint32_t number);

/* Function that core_identify() calls before it accesses a core. On the device it checks whether the fabric has been
   configured meanwhile, and searches for the thermometer. */
typedef void core_look(void *context);

struct core_access {
    core_read_word *read;
    core_write_word *write;
    core_capture_words *capture;
    void *context;
    /* NULL if the core is always there. */
    core_look *look;
    /* Like `capture`, for heads 3 and 4; NULL if the device has two heads only. */
    core_capture_words *further_capture;
};

#endif
