/* SPDX-License-Identifier: Apache-2.0 */

#include "clocks.h"

#include "arctrue_number_formats.h"
#include "registers.h"

_Static_assert(CLOCKS_FABRIC_HZ == ARCTRUE_CLOCK_HZ, "the core is built for this clock");

/* Input with pull-up and output of a UART, 3.3 V (L3_SEL = 7). */
#define PIN_UART_RECEIVE 0x000016E1U
#define PIN_UART_TRANSMIT 0x000016E0U
#define ARM_CLOCKS_ACTIVE 0x1F000000U
#define LEVEL_SHIFTERS_ON 0xFU

/* With the PLL in bypass and reset its factor may change; the UART is not yet used. */
static void set_up_io_pll(void) {
    uint32_t control = BOARD_IO_PLL_FACTOR << SLCR_PLL_FACTOR_SHIFT;
    register_write(SLCR_IO_PLL_CFG, BOARD_IO_PLL_CONFIGURATION);
    register_write(SLCR_IO_PLL_CTRL, control | SLCR_PLL_BYPASS | SLCR_PLL_RESET);
    register_write(SLCR_IO_PLL_CTRL, control | SLCR_PLL_BYPASS);
    while ((register_read(SLCR_PLL_STATUS) & SLCR_IO_PLL_LOCK) == 0) {
    }
    register_write(SLCR_IO_PLL_CTRL, control);
}

void clocks_set_up(void) {
    register_write(SLCR_UNLOCK, SLCR_UNLOCK_KEY);
    /* Begun anew after a fault, the fabric's clock must not stop. */
    uint32_t factor = (register_read(SLCR_IO_PLL_CTRL) >> SLCR_PLL_FACTOR_SHIFT) & 0x7FU;
    if (factor != BOARD_IO_PLL_FACTOR) {
        set_up_io_pll();
    }
    register_write(SLCR_ARM_CLK_CTRL, ARM_CLOCKS_ACTIVE | BOARD_PROCESSOR_DIVISOR << 8);
    register_write(SLCR_UART_CLK_CTRL, CLOCKS_UART_DIVISOR << 8 | 1U);
    register_write(SLCR_FPGA0_CLK_CTRL, CLOCKS_FABRIC_DIVISOR1 << 20 | CLOCKS_FABRIC_DIVISOR0 << 8);
    register_write(SLCR_MIO_PIN(BOARD_UART_RECEIVE_PIN), PIN_UART_RECEIVE);
    register_write(SLCR_MIO_PIN(BOARD_UART_TRANSMIT_PIN), PIN_UART_TRANSMIT);
    register_write(SLCR_LVL_SHFTR_EN, LEVEL_SHIFTERS_ON);
    register_write(SLCR_FPGA_RST_CTRL, 0);
}
