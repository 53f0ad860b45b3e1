/* SPDX-License-Identifier: Apache-2.0 */

/* The fabric: is it configured, and if not, load the bitstream that the flash carries through the
   configuration port (PCAP; UG585, chapter 6). Without a configured fabric an access to its window
   never ends: fabric_usable() says whether one may be made. */

#ifndef ARCTRUE_FABRIC_H
#define ARCTRUE_FABRIC_H

#include <stdbool.h>
#include <stdint.h>

#include "fabric_image.h"
#include "register_access.h"

enum fabric_state {
    /* Nothing done yet, and the steps of loading. */
    FABRIC_FIND,
    FABRIC_CHECK,
    FABRIC_PROGRAM_HIGH,
    FABRIC_PROGRAM_LOW,
    FABRIC_CLEAR,
    FABRIC_SEND,
    FABRIC_SENDING,
    FABRIC_WAIT_FOR_DONE,
    /* Ends: configured by this firmware, or before it came. */
    FABRIC_LOADED,
    FABRIC_CONFIGURED,
    /* Ends: refused. */
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
    /* An emulator, whose fabric window is memory. */
    bool emulated;
    /* Bytes checked, then bytes sent. */
    uint32_t place;
    uint32_t crc;
    /* When the present wait began. */
    uint32_t since_us;
};

void fabric_prepare(struct fabric *fabric, const struct register_access *access);

/* One piece of work, at most some ten milliseconds. True: there is more to do. */
bool fabric_step(struct fabric *fabric);

/* After a refusal: has somebody else configured the fabric meanwhile, by JTAG? */
void fabric_look_again(struct fabric *fabric);

/* True: the window of the fabric answers. */
bool fabric_usable(const struct fabric *fabric);

const char *fabric_state_name(enum fabric_state state);
/* What it means and what to do, for people. */
const char *fabric_state_meaning(enum fabric_state state);

#endif
