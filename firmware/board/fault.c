/* SPDX-License-Identifier: Apache-2.0 */

#include "fault.h"

#include <stdbool.h>
#include <stddef.h>

#include "assertion.h"
#include "memory_mapped.h"
#include "registers.h"
#include "uart.h"
#include "watchdog.h"

/* First and last address of the unmapped page below STACK_SEEN in on_chip_memory.ld. */
#define GUARD_FIRST 0x31000U
#define GUARD_LAST 0x31FFFU
#define CACHE_LINE 32U
#define RECORD_MARK 0x4152464CU
/* Mask of the kind of fault in DFSR, and the kind of an asynchronous external abort: the bus reported the error after
   the instruction had ended. */
#define STATE_KIND 0x40FU
#define STATE_LATE 0x406U

_Static_assert(FAULTS <= SLCR_REBOOT_KEPT >> SLCR_REBOOT_KEPT_SHIFT, "a fault fits into its bits");

static struct fault_record record __attribute__((section(".record")));
static struct kept_settings kept __attribute__((section(".record")));

void fault_taken(uint32_t code, uint32_t instruction, uint32_t address, uint32_t state)
    __attribute__((noreturn));
extern void start(void) __attribute__((noreturn));

static uint32_t check_of(const struct fault_record *held) {
    return ~(held->code + held->instruction + held->address + held->state);
}

const char *fault_name(enum fault_code code) {
    static const char *const names[FAULTS] = {
        "none",
        "undefined_instruction",
        "supervisor_call",
        "prefetch_abort",
        "data_abort",
        "stack_overflow",
        "watchdog",
        "hang",
        "bus_error",
        "assertion",
    };
    return (unsigned)code < FAULTS ? names[code] : "unknown";
}

/* Writes the data from the cache to memory, because the next start invalidates the cache. */
static void clean(const void *first, size_t bytes) {
    uintptr_t line = (uintptr_t)first & ~(uintptr_t)(CACHE_LINE - 1U);
    for (; line < (uintptr_t)first + bytes; line += CACHE_LINE) {
        __asm__ volatile("mcr p15, 0, %0, c7, c10, 1" ::"r"(line) : "memory");
    }
    __asm__ volatile("dsb" ::: "memory");
}

static void clean_record(void) {
    clean(&record, sizeof record);
}

struct kept_settings *fault_kept_settings(void) {
    return &kept;
}

void fault_keep(void) {
    clean(&kept, sizeof kept);
}

static bool is_valid(const struct fault_record *held) {
    return held->mark == RECORD_MARK && held->check == check_of(held) && held->code < FAULTS;
}

static void keep_code(uint32_t code) {
    register_write(SLCR_UNLOCK, SLCR_UNLOCK_KEY);
    register_write(SLCR_REBOOT_STATUS, (register_read(SLCR_REBOOT_STATUS) & ~SLCR_REBOOT_KEPT) |
                                           code << SLCR_REBOOT_KEPT_SHIFT);
}

struct fault_record fault_last(void) {
    struct fault_record last = {.code = FAULT_NONE};
    uint32_t status = register_read(SLCR_REBOOT_STATUS);
    bool resets = watchdog_has_reset();
    uint32_t name = (status & SLCR_REBOOT_KEPT) >> SLCR_REBOOT_KEPT_SHIFT;
    if (is_valid(&record)) {
        last = record;
    } else if (name != FAULT_NONE && name < FAULTS) {
        /* The watchdog has reset the processor while the processor handled this fault. */
        last.code = name;
    } else if (resets || status & SLCR_REBOOT_WATCHDOG) {
        last.code = FAULT_WATCHDOG;
    }
    record.mark = 0;
    clean_record();
    /* Software must clear these bits. After this write they show only the causes of later resets. */
    register_write(SLCR_REBOOT_STATUS, status & ~(SLCR_REBOOT_WATCHDOG | SLCR_REBOOT_KEPT));
    return last;
}

void fault_bus_errors_on(void) {
    __asm__ volatile("cpsie a" ::: "memory");
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

static void send_fault(void) {
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

/* Tells whether a failed ASSERT() caused the fault. Reading the address causes no further fault, because the processor
   has fetched the instruction from it. */
static bool is_assertion(uint32_t instruction) {
    return *(const volatile uint16_t *)(uintptr_t)instruction == ASSERTION_INSTRUCTION;
}

static struct fault_record record_of(uint32_t code, uint32_t instruction, uint32_t address,
                                     uint32_t state) {
    struct fault_record made = {RECORD_MARK, code, instruction, address, state, 0};
    if (code == FAULT_DATA_ABORT && (state & STATE_KIND) == STATE_LATE) {
        /* The address of a late bus error is not known. */
        made.code = FAULT_BUS_ERROR;
        made.address = 0;
    } else if (code == FAULT_DATA_ABORT && address >= GUARD_FIRST && address <= GUARD_LAST) {
        made.code = FAULT_STACK_OVERFLOW;
    }
    if (code == FAULT_UNDEFINED_INSTRUCTION && is_assertion(instruction)) {
        made.code = FAULT_ASSERTION;
    }
    made.check = check_of(&made);
    return made;
}

/* Handles a fault; start.S calls it on the stack of the fault's mode. The record is written first: if the code below
   does not end, the name of the fault is still known after the watchdog's reset. If a record has not been read yet, the
   handling of its fault has failed, so the handling is not repeated. */
void fault_taken(uint32_t code, uint32_t instruction, uint32_t address, uint32_t state) {
    if (!is_valid(&record)) {
        record = record_of(code, instruction, address, state);
        clean_record();
        keep_code(record.code);
        send_fault();
    }
    start();
}

void fault_hang(uint32_t instruction) {
    fault_taken(FAULT_HANG, instruction, 0, 0);
}
