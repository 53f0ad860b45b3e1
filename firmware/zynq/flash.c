/* SPDX-License-Identifier: Apache-2.0 */

#include "flash.h"

#include <stddef.h>

#include "registers.h"

/* Commands of flashes of 16 MB with three address bytes; only a Spansion flash has COMMAND_CLEAR_STATUS. */
#define COMMAND_PROGRAM_PAGE 0x02U
#define COMMAND_READ 0x03U
#define COMMAND_STATUS 0x05U
#define COMMAND_WRITE_ENABLE 0x06U
#define COMMAND_CLEAR_STATUS 0x30U
#define COMMAND_ID 0x9FU
#define COMMAND_ERASE_SECTOR 0xD8U
#define STATUS_AT_WORK 0x01U
/* Error flags of a Spansion flash after an erase or a programming; the flash stays busy until these flags are
   cleared. */
#define STATUS_WENT_WRONG 0x60U
/* Longest time for a word, which takes 1.3 us at 25 MHz. */
#define WORD_TIMEOUT_US 1000U
/* Longer than the times in all data sheets: 2.6 s for a sector of 256 KB, 3 s for a sector of 64 KB, 5 ms for a
   page. */
#define ERASE_TIMEOUT_US 8000000U
#define PROGRAM_TIMEOUT_US 50000U
#define QUEUE_WORDS 63U

/* The signals of the controller are on MIO 1 (select, with a pull-up) to MIO 6, as LVCMOS33: bank 500 of both boards
   has 3.3 V. UG585, slcr.MIO_PIN: function in bits 7 to 1, IO type in bits 11 to 9, pull-up in bit 12. */
#define PIN_SELECT 0x1602U
#define PIN_DATA_AND_CLOCK 0x0602U
enum { FIRST_PIN = 1, LAST_PIN = 6 };

#define KB 1024U
#define MAKER_SPANSION 0x01U
/* Fifth byte of the ID of a flash with sectors of 256 KB. */
#define SPANSION_SECTORS_OF_256_KB 0x00U

static const struct {
    uint32_t id;
    uint32_t sector_bytes;
} chips[] = {
    /* S25FL128S; its fifth byte states which of the two sector sizes it has. */
    {0x012018U, 64 * KB},
    /* N25Q128, W25Q128, MX25L128, IS25LP128, GD25Q128. */
    {0x20BA18U, 64 * KB},
    {0xEF4018U, 64 * KB},
    {0xEF7018U, 64 * KB},
    {0xC22018U, 64 * KB},
    {0x9D6018U, 64 * KB},
    {0xC84018U, 64 * KB},
};

static uint32_t read_controller(const struct flash *flash, uint32_t address) {
    return flash->access.read(flash->access.context, address);
}

static void write_controller(const struct flash *flash, uint32_t address, uint32_t word) {
    flash->access.write(flash->access.context, address, word);
}

static uint32_t now_us(const struct flash *flash) {
    return flash->access.microseconds(flash->access.context);
}

/* Drives the select line by software. The transmission begins when the queue is written; if the firmware is late,
   the clock waits. */
static void select(const struct flash *flash, bool selected) {
    write_controller(flash, QSPI_CONFIG,
                     QSPI_CONFIG_FLASH_MODE | QSPI_CONFIG_HOLD_HIGH | QSPI_CONFIG_WORDS |
                         QSPI_CONFIG_DIVIDE_BY_8 | QSPI_CONFIG_MASTER | QSPI_CONFIG_MANUAL_SELECT |
                         QSPI_CONFIG_OTHERS_NOT_SELECTED |
                         (selected ? 0U : QSPI_CONFIG_NOT_SELECTED));
}

static bool has_received(const struct flash *flash) {
    return (read_controller(flash, QSPI_STATUS) & QSPI_STATUS_RECEIVED) != 0;
}

static void drop_received(const struct flash *flash) {
    for (uint32_t word = 0; word < QUEUE_WORDS && has_received(flash); word++) {
        (void)read_controller(flash, QSPI_RXD);
    }
}

/* Sends four bytes, or one byte through QSPI_TXD1, and receives as many bytes. */
static bool exchange(const struct flash *flash, uint32_t place, uint32_t sent, uint32_t *word) {
    uint32_t start = now_us(flash);
    write_controller(flash, place, sent);
    while (!has_received(flash)) {
        if (now_us(flash) - start > WORD_TIMEOUT_US) {
            return false;
        }
    }
    *word = read_controller(flash, QSPI_RXD);
    return true;
}

/* Returns the word that sends a command, then the address with the upper byte first. */
static uint32_t command_word(uint32_t command, uint32_t address) {
    return command | (address >> 16 & 0xFFU) << 8 | (address >> 8 & 0xFFU) << 16 |
           (address & 0xFFU) << 24;
}

/* Sends a command with its address, then `number` words from `sent` or, if that is NULL, receives them into
   `received`. */
static bool run_command(const struct flash *flash, uint32_t word, const uint32_t *sent,
                        uint32_t *received, uint32_t number) {
    uint32_t nothing;
    select(flash, true);
    bool answers = exchange(flash, QSPI_TXD0, word, &nothing);
    for (uint32_t place = 0; answers && place < number; place++) {
        answers = exchange(flash, QSPI_TXD0, sent != NULL ? sent[place] : 0U,
                           sent != NULL ? &nothing : &received[place]);
    }
    select(flash, false);
    return answers;
}

static bool run_byte(const struct flash *flash, uint32_t command) {
    uint32_t nothing;
    select(flash, true);
    bool answers = exchange(flash, QSPI_TXD1, command, &nothing);
    select(flash, false);
    return answers;
}

/* Connects the controller's pins. The boot ROM connects them only if it starts from the flash, not if a debugger starts
   the firmware. */
static void connect_pins(const struct flash *flash) {
    write_controller(flash, SLCR_UNLOCK, SLCR_UNLOCK_KEY);
    for (uint32_t pin = FIRST_PIN; pin <= LAST_PIN; pin++) {
        write_controller(flash, SLCR_MIO_PIN(pin),
                         pin == FIRST_PIN ? PIN_SELECT : PIN_DATA_AND_CLOCK);
    }
}

void flash_prepare(struct flash *flash, const struct register_access *access) {
    *flash = (struct flash){.access = *access};
    connect_pins(flash);
}

/* Sets up the controller from any state: the boot ROM, a debugger or linear addressing may have changed it. */
static void take_controller(const struct flash *flash) {
    write_controller(flash, QSPI_EN, 0);
    write_controller(flash, QSPI_LQSPI_CFG, 0);
    write_controller(flash, QSPI_LPBK_DLY_ADJ, 0);
    write_controller(flash, QSPI_RX_THRESHOLD, 1);
    select(flash, false);
    write_controller(flash, QSPI_EN, 1);
    drop_received(flash);
}

static uint32_t sector_of(uint32_t id, uint32_t fifth_byte) {
    for (size_t place = 0; place < sizeof chips / sizeof chips[0]; place++) {
        if (chips[place].id == id) {
            bool large = id >> 16 == MAKER_SPANSION && fifth_byte == SPANSION_SECTORS_OF_256_KB;
            return large ? 256 * KB : chips[place].sector_bytes;
        }
    }
    return 0;
}

uint32_t flash_open(void *context) {
    struct flash *flash = context;
    uint32_t id[2];
    take_controller(flash);
    flash->id = 0;
    flash->sector_bytes = 0;
    select(flash, true);
    /* The first byte was received during the command; the other bytes are the ID. */
    bool answers =
        exchange(flash, QSPI_TXD0, COMMAND_ID, &id[0]) && exchange(flash, QSPI_TXD0, 0, &id[1]);
    select(flash, false);
    if (!answers) {
        return 0;
    }
    flash->id = (id[0] >> 8 & 0xFFU) << 16 | (id[0] >> 16 & 0xFFU) << 8 | id[0] >> 24;
    flash->sector_bytes = sector_of(flash->id, id[1] >> 8 & 0xFFU);
    if (flash->id >> 16 == MAKER_SPANSION && !run_byte(flash, COMMAND_CLEAR_STATUS)) {
        return 0;
    }
    return flash->sector_bytes;
}

bool flash_read(void *context, uint32_t address, uint32_t *words, uint32_t number) {
    return run_command(context, command_word(COMMAND_READ, address), NULL, words, number);
}

static bool begin_command(struct flash *flash, uint32_t command, uint32_t address,
                          const uint32_t *words, uint32_t number, uint32_t most_us) {
    flash->since_us = now_us(flash);
    flash->most_us = most_us;
    return run_byte(flash, COMMAND_WRITE_ENABLE) &&
           run_command(flash, command_word(command, address), words, NULL, number);
}

bool flash_erase(void *context, uint32_t address) {
    return begin_command(context, COMMAND_ERASE_SECTOR, address, NULL, 0, ERASE_TIMEOUT_US);
}

bool flash_program(void *context, uint32_t address, const uint32_t *words, uint32_t number) {
    return begin_command(context, COMMAND_PROGRAM_PAGE, address, words, number, PROGRAM_TIMEOUT_US);
}

enum flash_activity flash_activity(void *context) {
    const struct flash *flash = context;
    uint32_t answer = 0;
    select(flash, true);
    bool answers = exchange(flash, QSPI_TXD0, COMMAND_STATUS, &answer);
    select(flash, false);
    uint32_t status = answer >> 24;
    if (answers && flash->id >> 16 == MAKER_SPANSION && (status & STATUS_WENT_WRONG) != 0) {
        /* The content of the sector shows later whether the operation failed. */
        return run_byte(flash, COMMAND_CLEAR_STATUS) ? FLASH_IDLE : FLASH_STUCK;
    }
    if (answers && (status & STATUS_AT_WORK) == 0) {
        return FLASH_IDLE;
    }
    return now_us(flash) - flash->since_us > flash->most_us ? FLASH_STUCK : FLASH_AT_WORK;
}

struct flash_access flash_access_to(struct flash *flash) {
    return (struct flash_access){
        .open = flash_open,
        .read = flash_read,
        .erase = flash_erase,
        .program = flash_program,
        .activity = flash_activity,
        .context = flash,
    };
}
