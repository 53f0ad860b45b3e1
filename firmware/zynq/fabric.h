/* SPDX-License-Identifier: Apache-2.0 */

/* Configures the fabric if it is not configured: loads the bitstream in the flash through the configuration port
   (PCAP; UG585, chapter 6). If the fabric is not configured, an access to its window never ends; fabric_usable()
   tells whether an access is allowed. */

#ifndef ARCTRUE_FABRIC_H
#define ARCTRUE_FABRIC_H

#include <stdbool.h>
#include <stdint.h>

#include "fabric_image.h"
#include "register_access.h"

enum fabric_state {
    /* State before the loading, then the steps of the loading. */
    FABRIC_FIND,
    FABRIC_CHECK,
    FABRIC_PROGRAM_HIGH,
    FABRIC_PROGRAM_LOW,
    FABRIC_CLEAR,
    FABRIC_SEND,
    FABRIC_SENDING,
    FABRIC_WAIT_FOR_DONE,
    /* Final states: configured by this firmware, or otherwise (before its start, or later over JTAG). */
    FABRIC_LOADED,
    FABRIC_CONFIGURED,
    /* Final states in which the fabric is not configured; each names the reason. */
    FABRIC_NO_FLASH,
    FABRIC_NO_IMAGE,
    FABRIC_VERSION,
    FABRIC_LENGTH,
    FABRIC_NO_SYNC_WORD,
    FABRIC_CRC,
    FABRIC_NOT_READY,
    FABRIC_NOT_CLEARED,
    FABRIC_QUEUE_BUSY,
    FABRIC_DMA_ERROR,
    FABRIC_DMA_TIMEOUT,
    FABRIC_NOT_DONE,
    FABRIC_STATES,
};

struct fabric {
    struct register_access access;
    struct fabric_image image;
    enum fabric_state state;
    /* True in an emulator, whose fabric window is memory. */
    bool emulated;
    /* Number of checked bytes, later number of sent bytes. */
    uint32_t place;
    uint32_t crc;
    /* Time at which the present wait began. */
    uint32_t since_us;
};

void fabric_prepare(struct fabric *fabric, const struct register_access *access);

/* Does one piece of work, at most some ten milliseconds. Returns true if there is more to do. */
bool fabric_step(struct fabric *fabric);

/* If the loading has ended without a configured fabric, checks whether JTAG has configured it meanwhile. */
void fabric_look_again(struct fabric *fabric);

/* Tells whether an access to the fabric's window ends; false if it would never end. */
bool fabric_usable(const struct fabric *fabric);

const char *fabric_state_name(enum fabric_state state);
/* Returns a text with the meaning of the state and the action that the operator should take. */
const char *fabric_state_meaning(enum fabric_state state);

#endif
