/* SPDX-License-Identifier: Apache-2.0 */

/* Registers of the Zynq-7000's processor side that the firmware uses; names, addresses and bits
   from its technical reference manual (UG585). */

#ifndef ARCTRUE_BOARD_REGISTERS_H
#define ARCTRUE_BOARD_REGISTERS_H

#include <stdint.h>

static inline volatile uint32_t *register_at(uint32_t address) {
    return (volatile uint32_t *)(uintptr_t)address;
}

static inline void register_write(uint32_t address, uint32_t word) {
    *register_at(address) = word;
}

static inline uint32_t register_read(uint32_t address) {
    return *register_at(address);
}

/* System-level control. */
#define SLCR_UNLOCK 0xF8000008U
#define SLCR_UNLOCK_KEY 0xDF0DU
#define SLCR_IO_PLL_CTRL 0xF8000108U
#define SLCR_PLL_STATUS 0xF800010CU
#define SLCR_IO_PLL_LOCK 0x4U
#define SLCR_IO_PLL_CFG 0xF8000118U
#define SLCR_PLL_RESET 0x01U
#define SLCR_PLL_BYPASS 0x10U
#define SLCR_PLL_FACTOR_SHIFT 12U
#define SLCR_ARM_CLK_CTRL 0xF8000120U
#define SLCR_UART_CLK_CTRL 0xF8000154U
#define SLCR_FPGA0_CLK_CTRL 0xF8000170U
#define SLCR_FPGA_RST_CTRL 0xF8000240U
#define SLCR_REBOOT_STATUS 0xF8000258U
#define SLCR_REBOOT_WATCHDOG 0x00030000U
#define SLCR_MIO_PIN(pin) (0xF8000700U + 4U * (pin))
#define SLCR_LVL_SHFTR_EN 0xF8000900U

/* UART 0. */
#define UART_BASE 0xE0000000U
#define UART_CR (UART_BASE + 0x00U)
#define UART_MR (UART_BASE + 0x04U)
#define UART_IER (UART_BASE + 0x08U)
#define UART_IDR (UART_BASE + 0x0CU)
#define UART_ISR (UART_BASE + 0x14U)
#define UART_BAUDGEN (UART_BASE + 0x18U)
#define UART_RXWM (UART_BASE + 0x20U)
#define UART_SR (UART_BASE + 0x2CU)
#define UART_FIFO (UART_BASE + 0x30U)
#define UART_BAUDDIV (UART_BASE + 0x34U)
#define UART_SR_RECEIVE_EMPTY 0x02U
#define UART_SR_TRANSMIT_EMPTY 0x08U
#define UART_SR_TRANSMIT_FULL 0x10U
#define UART_RECEIVE_TRIGGER 0x01U

/* Private to a processor: interrupt controller, global timer, watchdog. */
#define GIC_ICCICR 0xF8F00100U
#define GIC_ICCPMR 0xF8F00104U
#define GIC_ICCIAR 0xF8F0010CU
#define GIC_ICCEOIR 0xF8F00110U
#define GIC_ICDDCR 0xF8F01000U
#define GIC_ICDISER(word) (0xF8F01100U + 4U * (word))
#define GIC_ICDIPR(interrupt) (0xF8F01400U + (interrupt))
#define GIC_ICDIPTR(interrupt) (0xF8F01800U + (interrupt))
#define INTERRUPT_GLOBAL_TIMER 27U
#define INTERRUPT_UART0 59U
#define TIMER_LOW 0xF8F00200U
#define TIMER_HIGH 0xF8F00204U
#define TIMER_CONTROL 0xF8F00208U
#define TIMER_STATUS 0xF8F0020CU
#define TIMER_COMPARE_LOW 0xF8F00210U
#define TIMER_COMPARE_HIGH 0xF8F00214U
#define TIMER_INCREMENT 0xF8F00218U
#define WATCHDOG_LOAD 0xF8F00620U
#define WATCHDOG_CONTROL 0xF8F00628U

#endif
