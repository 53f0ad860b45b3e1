/* SPDX-License-Identifier: Apache-2.0 */

#include "interrupts.h"

#include "memory_mapped.h"
#include "registers.h"

#define LOWEST_PRIORITY 0xF0U
#define MIDDLE_PRIORITY 0xA0U
#define FIRST_PROCESSOR 0x01U

/* Disables and clears all interrupts, because a debugger or another program may have enabled some. */
static void silence(void) {
    register_write(GIC_ICDDCR, 0);
    for (uint32_t word = 0; word < GIC_WORDS; word++) {
        register_write(GIC_ICDICER(word), 0xFFFFFFFFU);
        register_write(GIC_ICDICPR(word), 0xFFFFFFFFU);
    }
}

/* Makes an interrupt level-sensitive: a device holds its interrupt signal high until the firmware has served it. */
static void make_level(uint32_t interrupt) {
    uint32_t kinds = register_read(GIC_ICDICFR(interrupt));
    register_write(GIC_ICDICFR(interrupt), kinds & ~GIC_ICDICFR_EDGE(interrupt));
}

static void enable(uint32_t interrupt) {
    *(volatile uint8_t *)seen_at(GIC_ICDIPR(interrupt)) = MIDDLE_PRIORITY;
    *(volatile uint8_t *)seen_at(GIC_ICDIPTR(interrupt)) = FIRST_PROCESSOR;
    register_write(GIC_ICDISER(interrupt / 32U), 1U << (interrupt % 32U));
}

/* Ends an interrupt during which a fault occurred: it is still active and would block all others. */
static void finish(uint32_t interrupt) {
    if (register_read(GIC_ICDABR(interrupt / 32U)) & 1U << (interrupt % 32U)) {
        register_write(GIC_ICCEOIR, interrupt);
    }
}

void interrupts_fabric_off(void) {
    register_write(GIC_ICDICER(INTERRUPT_FABRIC / 32U), 1U << (INTERRUPT_FABRIC % 32U));
}

/* Enables the fabric's interrupt after the main program's writes have reached the core, so that the core's interrupt
   signal is low again. */
void interrupts_fabric_on(void) {
    registers_settle();
    register_write(GIC_ICDISER(INTERRUPT_FABRIC / 32U), 1U << (INTERRUPT_FABRIC % 32U));
}

/* Sleeps with interrupts disabled: an interrupt also ends the WFI of a processor whose interrupts are disabled. */
void interrupts_sleep_unless(bool (*work_waits)(void)) {
    __asm__ volatile("cpsid i" ::: "memory");
    if (!work_waits()) {
        __asm__ volatile("dsb\n\twfi" ::: "memory");
    }
    __asm__ volatile("cpsie i" ::: "memory");
}

void interrupts_set_up(void) {
    finish(INTERRUPT_GLOBAL_TIMER);
    finish(INTERRUPT_UART0);
    finish(INTERRUPT_FABRIC);
    silence();
    make_level(INTERRUPT_UART0);
    make_level(INTERRUPT_FABRIC);
    enable(INTERRUPT_GLOBAL_TIMER);
    enable(INTERRUPT_UART0);
    enable(INTERRUPT_FABRIC);
    register_write(GIC_ICCPMR, LOWEST_PRIORITY);
    register_write(GIC_ICCICR, 1);
    register_write(GIC_ICDDCR, 1);
    __asm__ volatile("dsb\n\tcpsie i" ::: "memory");
}
