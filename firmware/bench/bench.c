/* SPDX-License-Identifier: Apache-2.0 */

/* Runs both methods of the calibration, and a plain version of each, on the capture in the core's capture memory; it is
   a separate image for scripts/bench_firmware.py. It prints the ticks of each run. For each plain version it also
   prints the largest difference between its values and the values of the method, in 1e-9 of the largest value. */

#include <math.h>
#include <stddef.h>

#include "arctrue_registers.h"
#include "board_settings.h"
#include "capture.h"
#include "clocks.h"
#include "fault.h"
#include "fourier.h"
#include "further_orders.h"
#include "least_squares.h"
#include "memory_mapped.h"
#include "plain.h"
#include "reading_function.h"
#include "text.h"
#include "timer.h"
#include "uart.h"
#include "units.h"

#define CAPTURE_WINDOW 0x20000U
#define AT(register) (BOARD_CORE_BASE + (uint32_t)offsetof(arctrue_registers_t, register))
#define NOMINAL_DEGREES 33.0
enum { JUDGED_ORDERS = 32 };

static struct {
    struct uart uart;
    union {
        struct fourier_workspace fourier;
        struct least_squares_workspace least_squares;
        struct plain_workspace plain;
        struct reading_workspace reading;
        struct further_workspace further;
    } workspace;
    struct coefficients set;
    struct estimate estimate;
    double values[2 * ORDERS_MAX];
} bench;

void interrupt_taken(uint32_t instruction);
bool board_fabric_usable(void);

/* Does nothing: the start code needs this function, but no interrupt is enabled. */
void interrupt_taken(uint32_t instruction) {
    (void)instruction;
}

bool board_fabric_usable(void) {
    return true;
}

static void put(void *context, const char *characters, size_t number) {
    (void)context;
    for (size_t place = 0; place < number; place++) {
        uart_put(characters[place]);
    }
}

static const struct text_sink sink = {.put = put};

static void tell(const char *name, uint64_t ticks, double apart) {
    text_word(&sink, name);
    text_word(&sink, " ");
    text_unsigned(&sink, ticks);
    text_word(&sink, " ");
    text_fixed(&sink, apart * 1e9, 3);
    text_word(&sink, "\r\n");
}

static double apart(void) {
    const struct estimate *estimate = &bench.estimate;
    double largest = 0.0;
    double most = 0.0;
    for (uint32_t place = 0; place < estimate->orders; place++) {
        const struct harmonic *harmonic = &estimate->harmonic[place];
        double off = fabs(bench.values[place] - harmonic->cosine);
        off = fmax(off, fabs(bench.values[estimate->orders + place] - harmonic->sine));
        most = fmax(most, off);
        largest = fmax(largest, harmonic_amplitude(harmonic));
    }
    return most / largest;
}

/* Measures the sums for 32 loaded orders that the calibration does not fit; the judgement of fitted orders needs no
   such sums. */
static void judge(const struct turn *turn) {
    enum { FIRST = 4096, APART = 7 };
    bench.set.lanes = JUDGED_ORDERS;
    for (uint32_t lane = 0; lane < JUDGED_ORDERS; lane++) {
        bench.set.lane[lane].order = FIRST + APART * lane;
    }
    uint64_t start = timer_ticks();
    further_orders_look(&bench.workspace.further, turn, &bench.estimate, &bench.set);
    tell("judge", timer_ticks() - start, 0.0);
    start = timer_ticks();
    double off = plain_further_orders(&bench.workspace.further, turn, &bench.estimate);
    tell("plain_judge", timer_ticks() - start, off);
}

static void run(struct turn *turn, const struct calibration_settings *settings) {
    uint64_t start = timer_ticks();
    enum refusal reason =
        fourier_estimate(&bench.workspace.fourier, turn, settings, &bench.estimate);
    tell("fourier", timer_ticks() - start, reason);
    start = timer_ticks();
    plain_fourier(&bench.workspace.plain, turn, &bench.estimate, bench.values);
    tell("plain_fourier", timer_ticks() - start, apart());
    start = timer_ticks();
    estimate_as_function_of_reading(&bench.workspace.reading, &bench.estimate);
    tell("reading_function", timer_ticks() - start, 0.0);
    start = timer_ticks();
    reason =
        least_squares_estimate(&bench.workspace.least_squares, turn, settings, &bench.estimate);
    tell("least_squares", timer_ticks() - start, reason);
    start = timer_ticks();
    bool solved = plain_least_squares(&bench.workspace.plain, turn, &bench.estimate,
                                      settings->nominal_separation_rad, bench.values);
    tell("plain_least_squares", timer_ticks() - start, solved ? apart() : 1.0);
    judge(turn);
}

int main(void) {
    struct capture capture = {
        .words = (const volatile int32_t *)seen_at(BOARD_CORE_BASE + CAPTURE_WINDOW),
        .samples = register_read(AT(capture_header.sample_count)),
        .flags = register_read(AT(capture_header.flags)),
        .counts_per_rev = register_read(AT(counts_per_rev_active)),
        .clock_hz = register_read(AT(clock_hz)),
    };
    struct calibration_settings settings = {
        .nominal_separation_rad = NOMINAL_DEGREES * PI / 180.0,
        .separation = SEPARATION_AUTOMATIC,
        .orders = register_read(AT(scratch)),
    };
    struct turn turn;
    struct capture_fault fault;
    clocks_set_up();
    uart_set_up(&bench.uart);
    timer_set_up();
    uint64_t start = timer_ticks();
    enum refusal reason = capture_verify(&capture, settings.orders, &turn, &fault);
    tell("verify", timer_ticks() - start, reason);
    if (reason == NOT_REFUSED) {
        turn_align(&turn, settings.nominal_separation_rad);
        run(&turn, &settings);
    }
    text_word(&sink, "end\r\n");
    for (;;) {
        __asm__ volatile("wfi");
    }
}
