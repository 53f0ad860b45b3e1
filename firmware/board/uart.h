/* SPDX-License-Identifier: Apache-2.0 */

/* 8N1, 115200 baud unless BOARD_BAUD sets another rate. What is received waits in a ring while a calibration runs. */

#ifndef ARCTRUE_UART_H
#define ARCTRUE_UART_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* More than arrives while the longest calibration runs; what is beyond is lost. Where characters
   were lost a 0 stands for them: no line of text has one, so that none is taken for another. */
enum { UART_RING = 4096, UART_LOST = 0 };

struct uart {
    volatile uint32_t written;
    volatile uint32_t taken;
    /* Times that characters were lost since the set-up: FIFO or ring full. */
    volatile uint32_t overruns;
    /* The 0 has still to be written. */
    bool lost;
    /* Volatile too, so that a character is in it before `written` says so. */
    volatile uint8_t ring[UART_RING];
};

/* What is said waits in a ring, so that the main program does not: the FIFO holds 64 characters, and
   115,200 baud carry 11,520 of them a second. The longest line of telemetry fits. */
enum { UART_OUTPUT_RING = 4096 };

/* All 0: empty. */
struct uart_output {
    volatile uint32_t written;
    volatile uint32_t sent;
    /* The main program is filling the FIFO: the interrupt that comes meanwhile does not. */
    volatile bool filling;
    volatile uint8_t ring[UART_OUTPUT_RING];
};

void uart_set_up(struct uart *uart);
/* From the interrupt. */
void uart_interrupt(struct uart *uart);
bool uart_waits(const struct uart *uart);
bool uart_take(struct uart *uart, uint8_t *character);
/* Characters wait in the ring: the main program does not sleep meanwhile. */
bool uart_is_sending(const struct uart_output *output);
/* Characters that uart_send() takes without waiting. */
size_t uart_room(const struct uart_output *output);
/* Waits while the ring is full. */
void uart_send(struct uart_output *output, const char *characters, size_t number);
/* From an interrupt every 5 ms: at 115,200 baud (57.6 characters) before the FIFO has run empty. At
   higher rates 12,800 characters a second leave while the main program does not call uart_send(). */
void uart_go_on(struct uart_output *output);
/* Past the ring, at once; waits while the transmitter is full. */
void uart_put(char character);
/* Waits until the last bit has left. */
void uart_drain(void);

#endif
