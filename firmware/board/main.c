/* SPDX-License-Identifier: Apache-2.0 */

#include "application.h"
#include "board_settings.h"
#include "clocks.h"
#include "console.h"
#include "fault.h"
#include "interrupts.h"
#include "registers.h"
#include "timer.h"
#include "uart.h"

#define CAPTURE_WINDOW 0x20000U

/* The one context of the firmware. */
static struct {
    struct uart uart;
    struct application application;
    struct console console;
    uint64_t longest_step_ticks;
} firmware;

void interrupt_taken(void);

void interrupt_taken(void) {
    uint32_t acknowledged = register_read(GIC_ICCIAR);
    uint32_t interrupt = acknowledged & 0x3FFU;
    if (interrupt == INTERRUPT_GLOBAL_TIMER) {
        timer_interrupt();
    } else if (interrupt == INTERRUPT_UART0) {
        uart_interrupt(&firmware.uart);
    }
    register_write(GIC_ICCEOIR, acknowledged);
}

static uint32_t read_core(void *context, uint32_t offset) {
    (void)context;
    return register_read(BOARD_CORE_BASE + offset);
}

static void write_core(void *context, uint32_t offset, uint32_t word) {
    (void)context;
    register_write(BOARD_CORE_BASE + offset, word);
}

static const volatile int32_t *capture_words(void *context, uint32_t number) {
    (void)context;
    (void)number;
    return (const volatile int32_t *)(uintptr_t)(BOARD_CORE_BASE + CAPTURE_WINDOW);
}

static void put(void *context, const char *characters, size_t number) {
    (void)context;
    for (size_t place = 0; place < number; place++) {
        uart_put(characters[place]);
    }
    watchdog_feed();
}

static void work(void) {
    uint8_t character;
    uint64_t before = timer_ticks();
    application_step(&firmware.application);
    uint64_t ticks = timer_ticks() - before;
    if (ticks > firmware.longest_step_ticks) {
        firmware.longest_step_ticks = ticks;
        firmware.console.longest_step_us = (double)ticks * 1e6 / CLOCKS_TIMER_HZ;
    }
    while (uart_take(&firmware.uart, &character)) {
        console_receive(&firmware.console, character);
    }
    console_step(&firmware.console);
}

int main(void) {
    static const struct core_access core = {read_core, write_core, capture_words, NULL};
    static const struct text_sink sink = {put, NULL};
    clocks_set_up();
    uart_set_up(&firmware.uart);
    timer_set_up();
    interrupts_set_up();
    watchdog_start();
    application_prepare(&firmware.application, &core);
    console_prepare(&firmware.console, &firmware.application, &sink);
    firmware.console.reset_reason = fault_name(fault_last());
    application_start(&firmware.application);
    text_word(&sink, "arctrue " BOARD_NAME ", help tells the commands\r\n");
    for (;;) {
        watchdog_feed();
        work();
        /* The timer's interrupt ends it, at the latest a millisecond later. */
        __asm__ volatile("wfi");
    }
}
