/* SPDX-License-Identifier: Apache-2.0 */

#include "interrupts.h"

#include "registers.h"

#define LOWEST_PRIORITY 0xF0U
#define MIDDLE_PRIORITY 0xA0U
#define FIRST_PROCESSOR 0x01U

static void enable(uint32_t interrupt) {
    *(volatile uint8_t *)(uintptr_t)GIC_ICDIPR(interrupt) = MIDDLE_PRIORITY;
    *(volatile uint8_t *)(uintptr_t)GIC_ICDIPTR(interrupt) = FIRST_PROCESSOR;
    register_write(GIC_ICDISER(interrupt / 32U), 1U << (interrupt % 32U));
}

void interrupts_set_up(void) {
    register_write(GIC_ICDDCR, 0);
    enable(INTERRUPT_GLOBAL_TIMER);
    enable(INTERRUPT_UART0);
    register_write(GIC_ICCPMR, LOWEST_PRIORITY);
    register_write(GIC_ICCICR, 1);
    register_write(GIC_ICDDCR, 1);
    __asm__ volatile("dsb\n\tcpsie i" ::: "memory");
}
