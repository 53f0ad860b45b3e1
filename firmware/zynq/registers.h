/* SPDX-License-Identifier: Apache-2.0 */

/* Defines the registers of the Zynq-7000's processor side that the firmware uses; names, addresses and bits as in its
   technical reference manual (UG585). docs/firmware.md names the sources with which they were compared. */

#ifndef ARCTRUE_ZYNQ_REGISTERS_H
#define ARCTRUE_ZYNQ_REGISTERS_H

/* System-level control. */
#define SLCR_UNLOCK 0xF8000008U
#define SLCR_UNLOCK_KEY 0xDF0DU
#define SLCR_ARM_PLL_CTRL 0xF8000100U
#define SLCR_ARM_PLL_CFG 0xF8000110U
#define SLCR_ARM_PLL_LOCK 0x1U
#define SLCR_IO_PLL_CTRL 0xF8000108U
#define SLCR_PLL_STATUS 0xF800010CU
#define SLCR_IO_PLL_LOCK 0x4U
#define SLCR_IO_PLL_CFG 0xF8000118U
#define SLCR_PLL_RESET 0x01U
#define SLCR_PLL_BYPASS 0x10U
#define SLCR_PLL_FACTOR_SHIFT 12U
#define SLCR_ARM_CLK_CTRL 0xF8000120U
/* Bus clocks of the peripherals. */
#define SLCR_APER_CLK_CTRL 0xF800012CU
#define SLCR_APER_UART0 0x00100000U
#define SLCR_APER_QSPI 0x00800000U
#define SLCR_APER_I2C0 0x00040000U
#define SLCR_APER_GPIO 0x00400000U
#define SLCR_LQSPI_CLK_CTRL 0xF800014CU
#define SLCR_UART_CLK_CTRL 0xF8000154U
#define SLCR_PCAP_CLK_CTRL 0xF8000168U
#define SLCR_FPGA0_CLK_CTRL 0xF8000170U
#define SLCR_I2C_RST_CTRL 0xF8000224U
#define SLCR_I2C_RST_0 0x1U
#define SLCR_FPGA_RST_CTRL 0xF8000240U
/* Bit 0 belongs to processor 0. If it is 0, a reset by the watchdog of processor 0 resets the whole system, like the
   pin PS_SRST_B, which clears the fabric. If it is 1, such a reset affects only this processor. */
#define SLCR_RS_AWDT_CTRL 0xF800024CU
#define SLCR_RS_AWDT_PROCESSOR0 0x1U
/* Register of the configuration port: place where the boot ROM found its image, in units of 32 KB (UG585, chapter
   6). */
#define DEVCFG_MULTIBOOT_ADDR 0xF800702CU
#define DEVCFG_MULTIBOOT_PLACES 0x1FFFU
#define DEVCFG_MULTIBOOT_BYTES 0x8000U
/* This register survives every reset except the reset at power-on. The boot ROM uses the lower half and, after a failed
   boot, the four upper bits. */
#define SLCR_REBOOT_STATUS 0xF8000258U
#define SLCR_REBOOT_WATCHDOG 0x00030000U
#define SLCR_REBOOT_KEPT 0x0F000000U
#define SLCR_REBOOT_KEPT_SHIFT 24U
#define SLCR_BOOT_MODE 0xF800025CU
#define SLCR_BOOT_MODE_MASK 0x7U
#define SLCR_BOOT_MODE_QSPI 0x1U
#define SLCR_MIO_PIN(pin) (0xF8000700U + 4U * (pin))
#define SLCR_LVL_SHFTR_EN 0xF8000900U

/* Device configuration: the fabric's configuration port, and its DMA. */
#define DEVC_BASE 0xF8007000U
#define DEVC_CTRL (DEVC_BASE + 0x00U)
#define DEVC_INT_STS (DEVC_BASE + 0x0CU)
#define DEVC_INT_MASK (DEVC_BASE + 0x10U)
#define DEVC_STATUS (DEVC_BASE + 0x14U)
#define DEVC_DMA_SRC_ADDR (DEVC_BASE + 0x18U)
#define DEVC_DMA_DST_ADDR (DEVC_BASE + 0x1CU)
#define DEVC_DMA_SRC_LEN (DEVC_BASE + 0x20U)
#define DEVC_DMA_DST_LEN (DEVC_BASE + 0x24U)
#define DEVC_UNLOCK (DEVC_BASE + 0x34U)
#define DEVC_UNLOCK_KEY 0x757BDF0DU
#define DEVC_MCTRL (DEVC_BASE + 0x80U)
#define DEVC_CTRL_PROG_B 0x40000000U
#define DEVC_CTRL_PCAP_PR 0x08000000U
#define DEVC_CTRL_PCAP_MODE 0x04000000U
#define DEVC_CTRL_QUARTER_RATE 0x02000000U
#define DEVC_CTRL_ALWAYS_1 0x00006000U
#define DEVC_STATUS_QUEUE_FULL 0x80000000U
#define DEVC_STATUS_QUEUE_EMPTY 0x40000000U
#define DEVC_STATUS_INIT 0x00000010U
#define DEVC_INT_DMA_DONE 0x00002000U
#define DEVC_INT_DMA_AND_PCAP_DONE 0x00001000U
#define DEVC_INT_CONFIGURED 0x00000004U
/* Flags of errors: AXI responses and time-outs, DMA command and queue, lengths, authentication, single-event upset. */
#define DEVC_INT_ERRORS 0x00F0C860U
#define DEVC_MCTRL_LOOPBACK 0x00000010U
/* Reserved on silicon; QEMU sets it to identify itself. */
#define DEVC_MCTRL_QEMU 0x00000008U

/* The serial port to the converter of the fabric (XADC). */
#define XADC_CFG 0xF8007100U
#define XADC_MSTS 0xF800710CU
#define XADC_CMDFIFO 0xF8007110U
#define XADC_RDFIFO 0xF8007114U
#define XADC_MCTL 0xF8007118U
#define XADC_MSTS_DATA_EMPTY 0x00000100U

/* Quad-SPI controller, and the flash as memory. */
#define QSPI_CONFIG 0xE000D000U
#define QSPI_STATUS 0xE000D004U
#define QSPI_EN 0xE000D014U
/* Registers for four bytes to send and for received bytes; a single received byte is in the upper end. */
#define QSPI_TXD0 0xE000D01CU
#define QSPI_RXD 0xE000D020U
#define QSPI_RX_THRESHOLD 0xE000D02CU
#define QSPI_TXD1 0xE000D080U
#define QSPI_LPBK_DLY_ADJ 0xE000D038U
#define QSPI_LQSPI_CFG 0xE000D0A0U
#define QSPI_CONFIG_FLASH_MODE 0x80000000U
#define QSPI_CONFIG_BIG_ENDIAN 0x04000000U
#define QSPI_CONFIG_HOLD_HIGH 0x00080000U
#define QSPI_CONFIG_START 0x00010000U
#define QSPI_CONFIG_MANUAL_START 0x00008000U
#define QSPI_CONFIG_MANUAL_SELECT 0x00004000U
#define QSPI_CONFIG_NOT_SELECTED 0x00000400U
/* Reserved in this controller; these bits select three more flashes in the controller from which it was derived. */
#define QSPI_CONFIG_OTHERS_NOT_SELECTED 0x00003800U
#define QSPI_CONFIG_OTHER_CLOCK 0x00000100U
#define QSPI_CONFIG_WORDS 0x000000C0U
#define QSPI_CONFIG_DIVISOR 0x00000038U
#define QSPI_CONFIG_DIVIDE_BY_8 0x00000010U
#define QSPI_CONFIG_CLOCK_MODE 0x00000006U
#define QSPI_CONFIG_MASTER 0x00000001U
#define QSPI_STATUS_RECEIVED 0x00000010U
#define FLASH_BASE 0xFC000000U

/* I2C 0. */
#define I2C_BASE 0xE0004000U
#define I2C_CONTROL (I2C_BASE + 0x00U)
#define I2C_STATUS (I2C_BASE + 0x04U)
#define I2C_ADDRESS (I2C_BASE + 0x08U)
#define I2C_DATA (I2C_BASE + 0x0CU)
#define I2C_HAPPENED (I2C_BASE + 0x10U)
#define I2C_SIZE (I2C_BASE + 0x14U)
#define I2C_TIME_OUT (I2C_BASE + 0x1CU)
#define I2C_INTERRUPTS_OFF (I2C_BASE + 0x28U)
#define I2C_CONTROL_DIVISORS 0xFF00U
#define I2C_CONTROL_CLEAR_QUEUE 0x0040U
#define I2C_CONTROL_ACKNOWLEDGE 0x0008U
#define I2C_CONTROL_SEVEN_BITS 0x0004U
#define I2C_CONTROL_MASTER 0x0002U
#define I2C_CONTROL_READ 0x0001U
#define I2C_STATUS_RECEIVED 0x0020U
#define I2C_HAPPENED_ALL 0x02FFU
#define I2C_HAPPENED_DONE 0x0001U
#define I2C_HAPPENED_NO_ACKNOWLEDGE 0x0004U
/* Flags of errors: no acknowledge, time-out, overflow or underflow of a queue, bus lost to another master. */
#define I2C_HAPPENED_ERRORS 0x02ECU

/* General-purpose pins that leave through the fabric, bank 2: output values, input values, direction (1: out),
   enable. */
#define GPIO_DATA_2 0xE000A048U
#define GPIO_DATA_2_RO 0xE000A068U
#define GPIO_DIRM_2 0xE000A284U
#define GPIO_OEN_2 0xE000A288U

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
#define UART_SR_TRANSMIT_ACTIVE 0x800U
#define UART_RECEIVE_TRIGGER 0x01U
/* Flag: a character came while the FIFO was full. */
#define UART_RECEIVE_OVERFLOW 0x20U

/* Private to a processor: interrupt controller, global timer, watchdog. */
#define GIC_ICCICR 0xF8F00100U
#define GIC_ICCPMR 0xF8F00104U
#define GIC_ICCIAR 0xF8F0010CU
#define GIC_ICCEOIR 0xF8F00110U
#define GIC_ICDDCR 0xF8F01000U
#define GIC_ICDISER(word) (0xF8F01100U + 4U * (word))
#define GIC_ICDICER(word) (0xF8F01180U + 4U * (word))
#define GIC_ICDICPR(word) (0xF8F01280U + 4U * (word))
#define GIC_ICDABR(word) (0xF8F01300U + 4U * (word))
#define GIC_ICDIPR(interrupt) (0xF8F01400U + (interrupt))
#define GIC_ICDIPTR(interrupt) (0xF8F01800U + (interrupt))
/* Two bits per interrupt; the upper bit makes the interrupt edge sensitive. */
#define GIC_ICDICFR(interrupt) (0xF8F01C00U + 4U * ((interrupt) / 16U))
#define GIC_ICDICFR_EDGE(interrupt) (2U << 2U * ((interrupt) % 16U))
/* 96 interrupts in words of 32. */
#define GIC_WORDS 3U
/* Numbers from here on mean that no interrupt is pending. */
#define GIC_SPURIOUS 1020U
#define INTERRUPT_GLOBAL_TIMER 27U
#define INTERRUPT_UART0 59U
/* IRQ_F2P[0]. */
#define INTERRUPT_FABRIC 61U
#define TIMER_LOW 0xF8F00200U
#define TIMER_HIGH 0xF8F00204U
#define TIMER_CONTROL 0xF8F00208U
#define TIMER_STATUS 0xF8F0020CU
#define TIMER_COMPARE_LOW 0xF8F00210U
#define TIMER_COMPARE_HIGH 0xF8F00214U
#define TIMER_INCREMENT 0xF8F00218U
#define WATCHDOG_LOAD 0xF8F00620U
#define WATCHDOG_COUNTER 0xF8F00624U
#define WATCHDOG_CONTROL 0xF8F00628U
/* The watchdog sets this flag when it resets the processor. No reset of the processor clears the flag; writing 1 clears
   it. */
#define WATCHDOG_RESET_STATUS 0xF8F00630U
#define WATCHDOG_RESET_TAKEN 0x1U

#endif
