/* SPDX-License-Identifier: Apache-2.0 */

#ifndef ARCTRUE_CLOCKS_H
#define ARCTRUE_CLOCKS_H

#include "board_settings.h"

/* PLL_CFG of UG585: PLL_RES, PLL_CP, LOCK_CNT. */
#define CLOCKS_PLL_CONFIGURATION(resistor, charge_pump, lock_count) \
    ((lock_count) << 12 | (charge_pump) << 8 | (resistor) << 4)
#define CLOCKS_ARM_PLL_HZ (BOARD_CRYSTAL_HZ * BOARD_ARM_PLL_FACTOR)
#define CLOCKS_IO_PLL_HZ (BOARD_CRYSTAL_HZ * BOARD_IO_PLL_FACTOR)
#define CLOCKS_UART_DIVISOR 10U
#define CLOCKS_UART_HZ (CLOCKS_IO_PLL_HZ / CLOCKS_UART_DIVISOR)
/* Divisor for the clock of the flash controller, 200 MHz. The controller divides this clock by 8; at the resulting 25
   MHz no flash and no board needs an adjusted delay. */
#define CLOCKS_FLASH_DIVISOR 5U
/* Divisor for the clock of the configuration port, 200 MHz. */
#define CLOCKS_PORT_DIVISOR 5U
/* Two divisors for the clock of the fabric, 100 MHz. */
#define CLOCKS_FABRIC_DIVISOR0 5U
#define CLOCKS_FABRIC_DIVISOR1 2U
#define CLOCKS_FABRIC_HZ (CLOCKS_IO_PLL_HZ / (CLOCKS_FABRIC_DIVISOR0 * CLOCKS_FABRIC_DIVISOR1))
#define CLOCKS_PROCESSOR_HZ (CLOCKS_ARM_PLL_HZ / BOARD_PROCESSOR_DIVISOR)
/* Rate of the I2C controller's clock, which is the slowest clock of the ratio 6:2:1. */
#define CLOCKS_BUS_HZ (CLOCKS_PROCESSOR_HZ / 6U)
/* Rate of the clock of timers and watchdog. */
#define CLOCKS_TIMER_HZ (CLOCKS_PROCESSOR_HZ / 2U)

/* Sets up the clocks of processor, UART, flash and fabric, and the pins of the UART. */
void clocks_set_up(void);

#endif
