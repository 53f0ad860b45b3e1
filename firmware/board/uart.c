/* SPDX-License-Identifier: Apache-2.0 */

#include "uart.h"

#include "clocks.h"
#include "memory_mapped.h"
#include "registers.h"

/* `make firmware BAUD=921600` selects another rate. */
#ifndef BOARD_BAUD
#define BOARD_BAUD 115200U
#endif
_Static_assert(BOARD_BAUD >= 9600U && BOARD_BAUD <= 3000000U, "BAUD");
/* UG585, 19.2.3: a bit takes DIVISOR * SAMPLES_A_BIT clocks, and a register of 8 bits holds
   SAMPLES_A_BIT - 1. With the smallest divisor the rate is off by at most 1 % at 3 Mbaud. */
#define CLOCKS_A_BIT ((CLOCKS_UART_HZ + BOARD_BAUD / 2U) / BOARD_BAUD)
#define DIVISOR (CLOCKS_A_BIT / 257U + 1U)
#define SAMPLES_A_BIT ((CLOCKS_UART_HZ + BOARD_BAUD * DIVISOR / 2U) / (BOARD_BAUD * DIVISOR))
#define CONTROL_RESET_PATHS 0x03U
#define CONTROL_DISABLE_PATHS 0x28U
#define CONTROL_ENABLE_PATHS 0x14U
#define FIFO_CHARACTERS 64U
#define MODE_8N1 0x20U

void uart_set_up(struct uart *uart) {
    uart->written = 0;
    uart->taken = 0;
    uart->overruns = 0;
    uart->lost = false;
    register_write(UART_IDR, 0xFFFFFFFFU);
    /* UG585, 19.3: the baud rate may change only while both paths are off, and it needs a reset of both paths. */
    register_write(UART_CR, CONTROL_DISABLE_PATHS);
    register_write(UART_MR, MODE_8N1);
    register_write(UART_BAUDGEN, DIVISOR);
    register_write(UART_BAUDDIV, SAMPLES_A_BIT - 1U);
    register_write(UART_CR, CONTROL_DISABLE_PATHS | CONTROL_RESET_PATHS);
    while (register_read(UART_CR) & CONTROL_RESET_PATHS) {
    }
    register_write(UART_CR, CONTROL_ENABLE_PATHS);
    register_write(UART_RXWM, 1);
    register_write(UART_ISR, 0xFFFFFFFFU);
    register_write(UART_IER, UART_RECEIVE_TRIGGER | UART_RECEIVE_OVERFLOW);
}

static void note_loss(struct uart *uart) {
    uart->overruns = uart->overruns + !uart->lost;
    uart->lost = true;
}

static void write_ring(struct uart *uart, uint8_t character) {
    uart->ring[uart->written % UART_RING] = character;
    uart->written = uart->written + 1;
}

static void keep(struct uart *uart, uint8_t character) {
    uint32_t room = UART_RING - (uart->written - uart->taken);
    if (room < 1U + uart->lost) {
        note_loss(uart);
        return;
    }
    if (uart->lost) {
        write_ring(uart, UART_LOST);
        uart->lost = false;
    }
    write_ring(uart, character);
}

/* Moves received characters into the ring. It clears the flags before it empties the FIFO, so that a character that
   arrives after the last read interrupts again. */
void uart_interrupt(struct uart *uart) {
    bool overflow = (register_read(UART_ISR) & UART_RECEIVE_OVERFLOW) != 0;
    register_write(UART_ISR, UART_RECEIVE_TRIGGER | UART_RECEIVE_OVERFLOW);
    for (uint32_t number = 1; (register_read(UART_SR) & UART_SR_RECEIVE_EMPTY) == 0; number++) {
        keep(uart, (uint8_t)register_read(UART_FIFO));
        if (overflow && number == FIFO_CHARACTERS) {
            note_loss(uart);
        }
    }
}

bool uart_waits(const struct uart *uart) {
    return uart->taken != uart->written;
}

bool uart_take(struct uart *uart, uint8_t *character) {
    if (!uart_waits(uart)) {
        return false;
    }
    *character = uart->ring[uart->taken % UART_RING];
    uart->taken = uart->taken + 1;
    return true;
}

bool uart_is_sending(const struct uart_output *output) {
    return output->written != output->sent;
}

size_t uart_room(const struct uart_output *output) {
    return UART_OUTPUT_RING - (output->written - output->sent);
}

static void fill(struct uart_output *output) {
    while (output->sent != output->written &&
           (register_read(UART_SR) & UART_SR_TRANSMIT_FULL) == 0) {
        register_write(UART_FIFO, output->ring[output->sent % UART_OUTPUT_RING]);
        output->sent = output->sent + 1;
    }
}

static void fill_alone(struct uart_output *output) {
    output->filling = true;
    fill(output);
    output->filling = false;
}

void uart_send(struct uart_output *output, const char *characters, size_t number) {
    for (size_t place = 0; place < number; place++) {
        while (uart_room(output) == 0) {
            fill_alone(output);
        }
        output->ring[output->written % UART_OUTPUT_RING] = (uint8_t)characters[place];
        output->written = output->written + 1;
    }
    fill_alone(output);
}

void uart_go_on(struct uart_output *output) {
    if (!output->filling) {
        fill(output);
    }
}

void uart_put(char character) {
    while (register_read(UART_SR) & UART_SR_TRANSMIT_FULL) {
    }
    register_write(UART_FIFO, (uint8_t)character);
}

void uart_drain(void) {
    const uint32_t wanted = UART_SR_TRANSMIT_EMPTY;
    while ((register_read(UART_SR) & (wanted | UART_SR_TRANSMIT_ACTIVE)) != wanted) {
    }
}
