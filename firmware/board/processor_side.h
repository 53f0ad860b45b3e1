/* SPDX-License-Identifier: Apache-2.0 */

/* Defines the settings of the processor side of the TUL PYNQ-Z2 and the Digilent Arty Z7-20, both with an XC7Z020-1.
   They hold for every board that has no file of its own in boards/. They were not tried on a board.

   They were checked against the makers' own set-ups on github.com, Xilinx/PYNQ,
   boards/Pynq-Z2/petalinux_bsp/hardware_project/pynqz2.tcl, and Digilent/vivado-boards,
   new/board_files/arty-z7-20/A.0/preset.xml: crystal 50 MHz, processor 650 MHz at the ratio 6:2:1, UART 0 on MIO 14
   (in) and 15 (out) at 3.3 V with its clock at 100 MHz, quad-SPI flash on MIO 1 to 6, configuration port at 200 MHz,
   fabric clock 0 at 100 MHz; UART, port and fabric clock from the IO PLL. */

#ifndef ARCTRUE_PROCESSOR_SIDE_H
#define ARCTRUE_PROCESSOR_SIDE_H

#define BOARD_CRYSTAL_HZ 50000000U
/* Multiplication factor of the ARM PLL, which runs at 1300 MHz; the processor runs at half of this rate. */
#define BOARD_ARM_PLL_FACTOR 26U
#define BOARD_PROCESSOR_DIVISOR 2U
/* Multiplication factor of the IO PLL, which runs at 1000 MHz. */
#define BOARD_IO_PLL_FACTOR 20U
/* Loop resistor, charge pump and lock count of each factor: UG585, table 25-6. */
#define BOARD_ARM_PLL_CONFIGURATION CLOCKS_PLL_CONFIGURATION(12U, 2U, 375U)
#define BOARD_IO_PLL_CONFIGURATION CLOCKS_PLL_CONFIGURATION(12U, 2U, 500U)
#define BOARD_UART_RECEIVE_PIN 14U
#define BOARD_UART_TRANSMIT_PIN 15U
/* Address of the core in the window of M_AXI_GP0. */
#define BOARD_CORE_BASE 0x40000000U

#endif
