/* SPDX-License-Identifier: Apache-2.0 */

/* Digilent Arty Z7-20, XC7Z020-1: 50 MHz crystal at PS_CLK, USB serial port at UART 0 on MIO 14 and 15
   (bank 500, 3.3 V). Not tried on the board. */

#ifndef ARCTRUE_BOARD_SETTINGS_H
#define ARCTRUE_BOARD_SETTINGS_H

#define BOARD_NAME "arty_z7_20"
#define BOARD_CRYSTAL_HZ 50000000U
/* The boot ROM leaves the ARM PLL at 26 times the crystal: 1300 MHz, and the processor at half. */
#define BOARD_ARM_PLL_FACTOR 26U
#define BOARD_PROCESSOR_DIVISOR 2U
/* 1000 MHz; PLL_CFG for this factor: check against the table of UG585. */
#define BOARD_IO_PLL_FACTOR 20U
#define BOARD_IO_PLL_CONFIGURATION 0x001452C0U
#define BOARD_UART_RECEIVE_PIN 14U
#define BOARD_UART_TRANSMIT_PIN 15U
/* Where the core is in the window of M_AXI_GP0. */
#define BOARD_CORE_BASE 0x40000000U

#endif
