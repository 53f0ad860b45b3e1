/* SPDX-License-Identifier: Apache-2.0 */

#include "fault.h"

#include <stdbool.h>
#include <stddef.h>

#include "arctrue_registers.h"
#include "board_fabric.h"
#include "board_settings.h"
#include "memory_mapped.h"
#include "registers.h"
#include "uart.h"

/* The page below the stack in on_chip_memory.ld. */
#define GUARD_FIRST 0x18000U
#define GUARD_LAST 0x18FFFU
#define RECORD_MARK 0x4152464CU

static struct fault_record record __attribute__((section(".record")));

void fault_taken(uint32_t code, uint32_t instruction, uint32_t address, uint32_t state)
    __attribute__((noreturn));
extern void start(void) __attribute__((noreturn));

static uint32_t check_of(const struct fault_record *held) {
    return ~(held->code + held->instruction + held->address + held->state);
}

const char *fault_name(enum fault_code code) {
    static const char *const names[FAULTS] = {
        "none",       "undefined_instruction", "supervisor_call", "prefetch_abort",
        "data_abort", "stack_overflow",        "watchdog",        "hang",
    };
    return (unsigned)code < FAULTS ? names[code] : "unknown";
}

/* It must be in memory, not in a cache that the next start invalidates. */
static void clean_record(void) {
    __asm__ volatile("mcr p15, 0, %0, c7, c10, 1\n\tdsb" ::"r"(&record) : "memory");
}

static bool is_valid(const struct fault_record *held) {
    return held->mark == RECORD_MARK && held->check == check_of(held) && held->code < FAULTS;
}

struct fault_record fault_last(void) {
    struct fault_record last = {.code = FAULT_NONE};
    if (is_valid(&record)) {
        last = record;
    } else if (register_read(SLCR_REBOOT_STATUS) & SLCR_REBOOT_WATCHDOG) {
        last.code = FAULT_WATCHDOG;
    }
    record.mark = 0;
    clean_record();
    /* The flag stays until it is written: the next reset tells for itself. */
    register_write(SLCR_REBOOT_STATUS,
                   register_read(SLCR_REBOOT_STATUS) & ~SLCR_REBOOT_WATCHDOG);
    return last;
}

static void put_word(const char *word) {
    while (*word != '\0') {
        uart_put(*word++);
    }
}

static void put_hexadecimal(uint32_t value) {
    for (int shift = 28; shift >= 0; shift -= 4) {
        uart_put("0123456789ABCDEF"[value >> shift & 15U]);
    }
}

/* Without a fabric the access would never end. */
static void bypass(void) {
    if (!board_fabric_usable()) {
        return;
    }
    uint32_t control = BOARD_CORE_BASE + (uint32_t)offsetof(arctrue_registers_t, control);
    register_write(control, ARCTRUE_REGISTERS__CONTROL__OUTPUT_ENABLE_bm);
}

static void tell(void) {
    put_word("\r\nfault ");
    put_word(fault_name((enum fault_code)record.code));
    put_word(" at 0x");
    put_hexadecimal(record.instruction);
    put_word(" address 0x");
    put_hexadecimal(record.address);
    put_word(" state 0x");
    put_hexadecimal(record.state);
    put_word("\r\n");
    uart_drain();
}

/* From start.S, on the stack of the fault's mode. */
void fault_taken(uint32_t code, uint32_t instruction, uint32_t address, uint32_t state) {
    bool guard = code == FAULT_DATA_ABORT && address >= GUARD_FIRST && address <= GUARD_LAST;
    bypass();
    record = (struct fault_record){
        RECORD_MARK, guard ? FAULT_STACK_OVERFLOW : code, instruction, address, state, 0,
    };
    record.check = check_of(&record);
    tell();
    clean_record();
    start();
}

void fault_hang(uint32_t instruction) {
    fault_taken(FAULT_HANG, instruction, 0, 0);
}
