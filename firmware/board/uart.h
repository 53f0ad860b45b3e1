/* SPDX-License-Identifier: Apache-2.0 */

/* 115200 baud, 8N1. What is received waits in a ring while a calibration runs. */

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

void uart_set_up(struct uart *uart);
/* From the interrupt. */
void uart_interrupt(struct uart *uart);
bool uart_waits(const struct uart *uart);
bool uart_take(struct uart *uart, uint8_t *character);
/* Waits while the transmitter is full. */
void uart_put(char character);
/* Waits until the last bit has left. */
void uart_drain(void);

#endif
