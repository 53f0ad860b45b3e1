/* SPDX-License-Identifier: Apache-2.0 */

#include "fabric.h"

#include "crc32.h"
#include "registers.h"

enum { WORD_BYTES = 4 };
/* Number of bytes that one step checks, and number of bytes that the DMA sends in one piece. Both are multiples of the
   header's length, so that the DMA's source stays on a multiple of 64 bytes. */
#define CHECK_BYTES 0x4000U
#define SEND_BYTES 0x10000U
/* Longest waits for the cleared memory, for the end of a piece, and for DONE. Clearing takes some milliseconds; the
   flash needs at least 21 ms for one piece at 25 MHz on one wire. */
#define CLEAR_TIMEOUT_US 500000U
#define SEND_TIMEOUT_US 2000000U
#define DONE_TIMEOUT_US 500000U
/* Longest wait for the DMA's queue: the DMA may report a piece as done before the piece has left the queue. */
#define QUEUE_TIMEOUT_US 10000U
/* Destination address of the DMA for the configuration port, in place of memory. */
#define DESTINATION_PORT 0xFFFFFFFFU
/* Flag in an address: the DMA reports done only after the configuration port has taken every word. */
#define LAST_PIECE 1U
#define LEVEL_SHIFTERS_OFF 0x0U
#define LEVEL_SHIFTERS_TO_FABRIC 0xAU
#define LEVEL_SHIFTERS_ON 0xFU
#define FABRIC_RESETS_ALL 0xFU
/* Setting of the linear mode: fast read (0x0B) on one wire with one dummy byte, which every flash supports. */
#define LINEAR_FAST_READ 0x8000010BU

static const struct {
    const char *name;
    const char *meaning;
} states[FABRIC_STATES] = {
    [FABRIC_FIND] = {"find", "looks for a bitstream"},
    [FABRIC_CHECK] = {"check", "checks the bitstream"},
    [FABRIC_PROGRAM_HIGH] = {"program_high", "begins"},
    [FABRIC_PROGRAM_LOW] = {"program_low", "begins"},
    [FABRIC_CLEAR] = {"clear", "clears the fabric"},
    [FABRIC_SEND] = {"send", "sends the bitstream"},
    [FABRIC_SENDING] = {"sending", "sends the bitstream"},
    [FABRIC_WAIT_FOR_DONE] = {"wait_for_done", "waits for the fabric"},
    [FABRIC_LOADED] = {"loaded", "loaded from the flash"},
    [FABRIC_CONFIGURED] = {"configured", "was configured before"},
    [FABRIC_NO_FLASH] = {"no_flash", "not started from the flash: use JTAG, then rearm"},
    [FABRIC_NO_IMAGE] = {"no_image", "the flash carries no bitstream: write one, or use JTAG"},
    [FABRIC_VERSION] = {"version", "the bitstream's header is of another version: write it anew"},
    [FABRIC_LENGTH] = {"length", "the bitstream's length is impossible: write it anew"},
    [FABRIC_NO_SYNC_WORD] = {"no_sync_word", "no bitstream, or its bytes are not swapped"},
    [FABRIC_CRC] = {"crc", "the bitstream is damaged: write it anew"},
    [FABRIC_NOT_READY] = {"not_ready", "the configuration port does not become ready"},
    [FABRIC_NOT_CLEARED] = {"not_cleared", "the fabric is not cleared"},
    [FABRIC_QUEUE_BUSY] = {"queue_busy", "the configuration port is in use by another master"},
    [FABRIC_DMA_ERROR] = {"dma_error", "the bitstream's transfer went wrong"},
    [FABRIC_DMA_TIMEOUT] = {"dma_timeout", "the bitstream's transfer does not end"},
    [FABRIC_NOT_DONE] = {"not_done", "the fabric refused it: a bitstream of another part?"},
};

static uint32_t fabric_read(const struct fabric *fabric, uint32_t address) {
    return fabric->access.read(fabric->access.context, address);
}

static void fabric_write(const struct fabric *fabric, uint32_t address, uint32_t word) {
    fabric->access.write(fabric->access.context, address, word);
}

static void enter(struct fabric *fabric, enum fabric_state state) {
    fabric->state = state;
    fabric->since_us = fabric->access.microseconds(fabric->access.context);
}

static bool waited(const struct fabric *fabric, uint32_t most_us) {
    return fabric->access.microseconds(fabric->access.context) - fabric->since_us > most_us;
}

/* Switches the level shifters on in both directions and releases the fabric's resets. */
static void connect(const struct fabric *fabric) {
    fabric_write(fabric, SLCR_UNLOCK, SLCR_UNLOCK_KEY);
    fabric_write(fabric, SLCR_LVL_SHFTR_EN, LEVEL_SHIFTERS_ON);
    fabric_write(fabric, SLCR_FPGA_RST_CTRL, 0);
}

static void disconnect(const struct fabric *fabric) {
    fabric_write(fabric, SLCR_UNLOCK, SLCR_UNLOCK_KEY);
    fabric_write(fabric, SLCR_FPGA_RST_CTRL, FABRIC_RESETS_ALL);
    fabric_write(fabric, SLCR_LVL_SHFTR_EN, LEVEL_SHIFTERS_OFF);
    fabric_write(fabric, SLCR_LVL_SHFTR_EN, LEVEL_SHIFTERS_TO_FABRIC);
}

/* Sets the controller up for linear addressing (UG585, 12.3); flash_prepare() has connected its pins. The set-up
   does not rely on settings of the boot ROM. With one data wire, another wire is HOLD of the flash and must be driven.
   */
static void open_flash(const struct fabric *fabric) {
    const uint32_t off = QSPI_CONFIG_BIG_ENDIAN | QSPI_CONFIG_START | QSPI_CONFIG_MANUAL_START |
                         QSPI_CONFIG_MANUAL_SELECT | QSPI_CONFIG_NOT_SELECTED |
                         QSPI_CONFIG_OTHER_CLOCK | QSPI_CONFIG_DIVISOR | QSPI_CONFIG_CLOCK_MODE;
    const uint32_t on = QSPI_CONFIG_FLASH_MODE | QSPI_CONFIG_HOLD_HIGH | QSPI_CONFIG_WORDS |
                        QSPI_CONFIG_DIVIDE_BY_8 | QSPI_CONFIG_MASTER;
    fabric_write(fabric, QSPI_EN, 0);
    fabric_write(fabric, QSPI_CONFIG, (fabric_read(fabric, QSPI_CONFIG) & ~off) | on);
    fabric_write(fabric, QSPI_LPBK_DLY_ADJ, 0);
    fabric_write(fabric, QSPI_LQSPI_CFG, LINEAR_FAST_READ);
    fabric_write(fabric, QSPI_EN, 1);
}

static enum fabric_state state_of(enum fabric_image_answer answer) {
    switch (answer) {
    case FABRIC_IMAGE_FOUND:
        return FABRIC_CHECK;
    case FABRIC_IMAGE_OTHER_VERSION:
        return FABRIC_VERSION;
    case FABRIC_IMAGE_BAD_LENGTH:
        return FABRIC_LENGTH;
    case FABRIC_IMAGE_NO_SYNC_WORD:
        return FABRIC_NO_SYNC_WORD;
    case FABRIC_IMAGE_ABSENT:
    default:
        return FABRIC_NO_IMAGE;
    }
}

/* Tells whether QEMU emulates the chip. Newer versions of QEMU set a flag; version 7.2 has no device at this address,
   which then reads as 0. On silicon, bits 13 and 14 of the control register are always 1. */
static bool is_emulated(const struct fabric *fabric) {
    return (fabric_read(fabric, DEVC_MCTRL) & DEVC_MCTRL_QEMU) != 0 ||
           (fabric_read(fabric, DEVC_CTRL) & DEVC_CTRL_ALWAYS_1) == 0;
}

static void find(struct fabric *fabric) {
    fabric_write(fabric, DEVC_UNLOCK, DEVC_UNLOCK_KEY);
    fabric->emulated = is_emulated(fabric);
    if (fabric_read(fabric, DEVC_INT_STS) & DEVC_INT_CONFIGURED) {
        connect(fabric);
        enter(fabric, FABRIC_CONFIGURED);
        return;
    }
    uint32_t mode = fabric_read(fabric, SLCR_BOOT_MODE) & SLCR_BOOT_MODE_MASK;
    if (mode != SLCR_BOOT_MODE_QSPI) {
        enter(fabric, FABRIC_NO_FLASH);
        return;
    }
    open_flash(fabric);
    fabric->place = 0;
    fabric->crc = 0;
    enter(fabric, state_of(fabric_image_read(&fabric->access, FLASH_BASE + FLASH_MAP_BITSTREAM,
                                             &fabric->image)));
}

static uint32_t left(const struct fabric *fabric, uint32_t most) {
    uint32_t bytes = fabric->image.length - fabric->place;
    return bytes < most ? bytes : most;
}

static void program(const struct fabric *fabric, bool high) {
    uint32_t control =
        fabric_read(fabric, DEVC_CTRL) & ~(DEVC_CTRL_PROG_B | DEVC_CTRL_QUARTER_RATE);
    control |= DEVC_CTRL_PCAP_PR | DEVC_CTRL_PCAP_MODE | (high ? DEVC_CTRL_PROG_B : 0U);
    fabric_write(fabric, DEVC_CTRL, control);
}

/* Adds the next part of the bitstream to the CRC. After the last part, disconnects the fabric if the CRC is right. */
static void check_bitstream(struct fabric *fabric) {
    uint32_t end = fabric->place + left(fabric, CHECK_BYTES);
    for (; fabric->place < end; fabric->place += WORD_BYTES) {
        fabric->crc =
            crc32_add_word(fabric->crc, fabric_read(fabric, fabric->image.address + fabric->place));
    }
    if (end < fabric->image.length) {
        return;
    }
    if (fabric->crc != fabric->image.crc) {
        enter(fabric, FABRIC_CRC);
        return;
    }
    disconnect(fabric);
    program(fabric, true);
    enter(fabric, FABRIC_PROGRAM_HIGH);
}

/* Waits for INIT, which follows PROG_B: high, low, and high again when the memory is cleared. */
static void follow_init(struct fabric *fabric) {
    bool high = fabric->state != FABRIC_PROGRAM_LOW;
    bool init = (fabric_read(fabric, DEVC_STATUS) & DEVC_STATUS_INIT) != 0;
    if (init != high) {
        if (waited(fabric, CLEAR_TIMEOUT_US)) {
            enter(fabric, fabric->state == FABRIC_CLEAR ? FABRIC_NOT_CLEARED : FABRIC_NOT_READY);
        }
        return;
    }
    if (fabric->state == FABRIC_PROGRAM_HIGH) {
        program(fabric, false);
        enter(fabric, FABRIC_PROGRAM_LOW);
    } else if (fabric->state == FABRIC_PROGRAM_LOW) {
        program(fabric, true);
        enter(fabric, FABRIC_CLEAR);
    } else {
        fabric->place = 0;
        fabric_write(fabric, DEVC_MCTRL, fabric_read(fabric, DEVC_MCTRL) & ~DEVC_MCTRL_LOOPBACK);
        fabric_write(fabric, DEVC_INT_MASK, 0xFFFFFFFFU);
        fabric_write(fabric, DEVC_INT_STS, 0xFFFFFFFFU);
        enter(fabric, FABRIC_SEND);
    }
}

static void send(struct fabric *fabric) {
    uint32_t status = fabric_read(fabric, DEVC_STATUS);
    if (status & DEVC_STATUS_QUEUE_FULL || !(status & DEVC_STATUS_QUEUE_EMPTY)) {
        if (waited(fabric, QUEUE_TIMEOUT_US)) {
            enter(fabric, FABRIC_QUEUE_BUSY);
        }
        return;
    }
    uint32_t bytes = left(fabric, SEND_BYTES);
    bool last = fabric->place + bytes == fabric->image.length;
    fabric_write(fabric, DEVC_INT_STS, DEVC_INT_DMA_DONE | DEVC_INT_DMA_AND_PCAP_DONE);
    fabric_write(fabric, DEVC_DMA_SRC_ADDR,
                 (fabric->image.address + fabric->place) | (last ? LAST_PIECE : 0U));
    fabric_write(fabric, DEVC_DMA_DST_ADDR, DESTINATION_PORT);
    fabric_write(fabric, DEVC_DMA_SRC_LEN, bytes / WORD_BYTES);
    /* This write starts the DMA. */
    fabric_write(fabric, DEVC_DMA_DST_LEN, 0);
    fabric->place += bytes;
    enter(fabric, FABRIC_SENDING);
}

static void watch_transfer(struct fabric *fabric) {
    bool last = fabric->place == fabric->image.length;
    uint32_t wanted = last ? DEVC_INT_DMA_AND_PCAP_DONE : DEVC_INT_DMA_DONE;
    uint32_t happened = fabric_read(fabric, DEVC_INT_STS);
    if (happened & DEVC_INT_ERRORS) {
        enter(fabric, FABRIC_DMA_ERROR);
    } else if (happened & wanted) {
        enter(fabric, last ? FABRIC_WAIT_FOR_DONE : FABRIC_SEND);
    } else if (waited(fabric, SEND_TIMEOUT_US)) {
        enter(fabric, FABRIC_DMA_TIMEOUT);
    }
}

static void wait_for_done(struct fabric *fabric) {
    if (fabric_read(fabric, DEVC_INT_STS) & DEVC_INT_CONFIGURED) {
        connect(fabric);
        enter(fabric, FABRIC_LOADED);
    } else if (waited(fabric, DONE_TIMEOUT_US)) {
        enter(fabric, FABRIC_NOT_DONE);
    }
}

void fabric_prepare(struct fabric *fabric, const struct register_access *access) {
    *fabric = (struct fabric){.access = *access, .state = FABRIC_FIND};
}

bool fabric_step(struct fabric *fabric) {
    switch (fabric->state) {
    case FABRIC_FIND:
        find(fabric);
        break;
    case FABRIC_CHECK:
        check_bitstream(fabric);
        break;
    case FABRIC_PROGRAM_HIGH:
    case FABRIC_PROGRAM_LOW:
    case FABRIC_CLEAR:
        follow_init(fabric);
        break;
    case FABRIC_SEND:
        send(fabric);
        break;
    case FABRIC_SENDING:
        watch_transfer(fabric);
        break;
    case FABRIC_WAIT_FOR_DONE:
        wait_for_done(fabric);
        break;
    default:
        return false;
    }
    return fabric->state < FABRIC_LOADED;
}

void fabric_look_again(struct fabric *fabric) {
    bool refused = fabric->state > FABRIC_CONFIGURED;
    if (refused && fabric_read(fabric, DEVC_INT_STS) & DEVC_INT_CONFIGURED) {
        connect(fabric);
        enter(fabric, FABRIC_CONFIGURED);
    }
}

bool fabric_usable(const struct fabric *fabric) {
    return fabric->emulated || fabric->state == FABRIC_LOADED || fabric->state == FABRIC_CONFIGURED;
}

const char *fabric_state_name(enum fabric_state state) {
    return (unsigned)state < FABRIC_STATES ? states[state].name : "unknown";
}

const char *fabric_state_meaning(enum fabric_state state) {
    return (unsigned)state < FABRIC_STATES ? states[state].meaning : "unknown";
}
