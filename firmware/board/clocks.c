/* SPDX-License-Identifier: Apache-2.0 */

#include "clocks.h"

#include "arctrue_number_formats.h"
#include "memory_mapped.h"
#include "registers.h"

_Static_assert(CLOCKS_FABRIC_HZ == ARCTRUE_CLOCK_HZ, "the core is built for this clock");

/* Zynq-7000 of speed grade -1 (DS187): PS_CLK 30 to 60 MHz, PLLs 780 to 1600 MHz, processor at
   most 667 MHz at the ratio 6:2:1. */
#define PLL_LEAST_HZ 780000000U
#define PLL_MOST_HZ 1600000000U
_Static_assert(BOARD_CRYSTAL_HZ >= 30000000U && BOARD_CRYSTAL_HZ <= 60000000U, "PS_CLK");
_Static_assert(CLOCKS_ARM_PLL_HZ >= PLL_LEAST_HZ && CLOCKS_ARM_PLL_HZ <= PLL_MOST_HZ, "ARM PLL");
_Static_assert(CLOCKS_IO_PLL_HZ >= PLL_LEAST_HZ && CLOCKS_IO_PLL_HZ <= PLL_MOST_HZ, "IO PLL");
_Static_assert(CLOCKS_PROCESSOR_HZ <= 667000000U, "processor");

/* Settings of the UART's pins: an input with a pull-up, and an output, both at 3.3 V; the function is selected by
   L3_SEL = 7. */
#define PIN_UART_RECEIVE 0x000016E1U
#define PIN_UART_TRANSMIT 0x000016E0U
#define ARM_CLOCKS_ACTIVE 0x1F000000U

struct pll {
    uint32_t control;
    uint32_t configuration;
    uint32_t locked;
};

/* Sets the factor of a PLL, which may change only while the PLL is in bypass and reset. After a restart the PLL has the
   factor already and is not touched, so that the fabric's clock does not stop. */
static void set_up_pll(const struct pll *pll, uint32_t factor, uint32_t configuration) {
    uint32_t control = factor << SLCR_PLL_FACTOR_SHIFT;
    if (register_read(pll->control) == control) {
        return;
    }
    register_write(pll->configuration, configuration);
    register_write(pll->control, control | SLCR_PLL_BYPASS | SLCR_PLL_RESET);
    register_write(pll->control, control | SLCR_PLL_BYPASS);
    while ((register_read(SLCR_PLL_STATUS) & pll->locked) == 0) {
    }
    register_write(pll->control, control);
}

/* Writes a register of the clocks or pins only if it does not hold this word already: after a restart a correct clock
   is not touched, because the fabric is running. */
static void set_control(uint32_t address, uint32_t word) {
    if (register_read(address) != word) {
        register_write(address, word);
    }
}

void clocks_set_up(void) {
    static const struct pll arm = {SLCR_ARM_PLL_CTRL, SLCR_ARM_PLL_CFG, SLCR_ARM_PLL_LOCK};
    static const struct pll io = {SLCR_IO_PLL_CTRL, SLCR_IO_PLL_CFG, SLCR_IO_PLL_LOCK};
    register_write(SLCR_UNLOCK, SLCR_UNLOCK_KEY);
    set_up_pll(&arm, BOARD_ARM_PLL_FACTOR, BOARD_ARM_PLL_CONFIGURATION);
    set_up_pll(&io, BOARD_IO_PLL_FACTOR, BOARD_IO_PLL_CONFIGURATION);
    set_control(SLCR_ARM_CLK_CTRL, ARM_CLOCKS_ACTIVE | BOARD_PROCESSOR_DIVISOR << 8);
    set_control(SLCR_APER_CLK_CTRL, register_read(SLCR_APER_CLK_CTRL) | SLCR_APER_UART0 |
                                        SLCR_APER_QSPI | SLCR_APER_I2C0 | SLCR_APER_GPIO);
    set_control(SLCR_LQSPI_CLK_CTRL, CLOCKS_FLASH_DIVISOR << 8 | 1U);
    set_control(SLCR_UART_CLK_CTRL, CLOCKS_UART_DIVISOR << 8 | 1U);
    set_control(SLCR_PCAP_CLK_CTRL, CLOCKS_PORT_DIVISOR << 8 | 1U);
    set_control(SLCR_FPGA0_CLK_CTRL, CLOCKS_FABRIC_DIVISOR1 << 20 | CLOCKS_FABRIC_DIVISOR0 << 8);
    set_control(SLCR_MIO_PIN(BOARD_UART_RECEIVE_PIN), PIN_UART_RECEIVE);
    set_control(SLCR_MIO_PIN(BOARD_UART_TRANSMIT_PIN), PIN_UART_TRANSMIT);
    /* The clocks must run before the first access to a device that needs them. */
    registers_settle();
}
