/* SPDX-License-Identifier: Apache-2.0 */

/* Sends and receives characters through the UART, with 8N1 and 115200 baud unless BOARD_BAUD sets another rate.
   Received characters wait in a ring while a calibration runs. */

#ifndef ARCTRUE_UART_H
#define ARCTRUE_UART_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* The ring holds the characters that 115,200 baud transmit in 0.35 s. A calibration may take longer, but a sender that
   waits for the answer to each line never fills the ring. Characters for which the ring has no room are lost; a 0 marks
   the place where characters were lost. No line of text contains a 0, so a damaged line is never taken for another
   line. */
enum { UART_RING = 4096, UART_LOST = 0 };

struct uart {
    volatile uint32_t written;
    volatile uint32_t taken;
    /* Number of times that characters were lost since the set-up, because FIFO or ring was full. */
    volatile uint32_t overruns;
    /* True while the 0 for lost characters is not yet in the ring. */
    bool lost;
    /* The characters are volatile too, so that a character is stored before `written` counts it. */
    volatile uint8_t ring[UART_RING];
};

/* Sent characters wait in a ring, so that the main program does not wait: the FIFO holds 64 characters, and 115,200
   baud transmit 11,520 characters per second. The longest line of telemetry fits into the ring. */
enum { UART_OUTPUT_RING = 4096 };

/* A ring whose members are all 0 is empty. */
struct uart_output {
    volatile uint32_t written;
    volatile uint32_t sent;
    /* True while the main program fills the FIFO; an interrupt must not fill it then. */
    volatile bool filling;
    volatile uint8_t ring[UART_OUTPUT_RING];
};

void uart_set_up(struct uart *uart);
/* Serves the UART's interrupt. */
void uart_interrupt(struct uart *uart);
bool uart_waits(const struct uart *uart);
bool uart_take(struct uart *uart, uint8_t *character);
/* Tells whether characters wait in the ring; the main program does not sleep then. */
bool uart_is_sending(const struct uart_output *output);
/* Returns the number of characters that uart_send() takes without waiting. */
size_t uart_room(const struct uart_output *output);
/* Sends characters; waits while the ring is full. */
void uart_send(struct uart_output *output, const char *characters, size_t number);
/* Refills the FIFO; called by an interrupt every 5 ms. In this time 115,200 baud transmit 57.6 characters, so the
   FIFO does not run empty. At higher rates 12,800 characters per second are sent while the main program does not
   call uart_send(). */
void uart_go_on(struct uart_output *output);
/* Sends a character at once, not through the ring; waits while the transmitter is full. */
void uart_put(char character);
/* Waits until the last bit has been sent. */
void uart_drain(void);

#endif
