/* SPDX-License-Identifier: Apache-2.0 */

/* Verifies any capture and, if it is accepted, calibrates it with both methods, selects orders, quantises and judges
   them. Every accepted result must be finite and fit the gateware.

   Parts of the input, with their numbers of bytes: choices (1), orders (1), counts per turn (4), flags (2), period or,
   for an even turn, head 2's zero (4), angle offset (4), then the samples. Bit 0 of the choices states whether samples
   are words or small departures from an even turn; the second form makes usable turns likely. */

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arctrue_number_formats.h"
#include "capture.h"
#include "coefficients.h"
#include "fourier.h"
#include "fuzz_target.h"
#include "gate.h"
#include "least_squares.h"
#include "reading_function.h"
#include "selection.h"
#include "units.h"

enum { HEADER_BYTES = 16, SAMPLES_MOST = 2048, LANES = 32 };
enum { CHOICE_EVEN = 1, CHOICE_BACKWARD = 2, CHOICE_NOMINAL = 4, CHOICE_LARGE = 8 };

static struct {
    int32_t words[2 * SAMPLES_MOST];
    struct fourier_workspace fourier;
    struct least_squares_workspace least_squares;
    struct reading_workspace reading;
    struct estimate estimate;
    struct coefficients coefficients;
    enum verdict verdicts[ORDERS_MAX];
} fuzz;

static void require(bool holds) {
    if (!holds) {
        abort();
    }
}

static uint32_t word_of(const uint8_t *bytes) {
    return (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 |
           (uint32_t)bytes[3] << 24;
}

static uint32_t fill_words(const uint8_t *data, size_t size) {
    size_t samples = size / 8 < SAMPLES_MOST ? size / 8 : SAMPLES_MOST;
    for (size_t place = 0; place < 2 * samples; place++) {
        fuzz.words[place] = (int32_t)word_of(data + 4 * place);
    }
    return (uint32_t)samples;
}

static uint32_t fill_even(const uint8_t *data, size_t size, uint32_t counts_per_rev,
                          unsigned choices) {
    size_t samples = size / 2;
    if (samples > SAMPLES_MOST) {
        samples = SAMPLES_MOST;
    }
    double step = samples > 1 ? counts_per_rev / (double)(samples - 1) : 0.0;
    double most = choices & CHOICE_LARGE ? 0.04 * step / 128.0 : 0.01;
    int64_t apart = (int64_t)(counts_per_rev * 33.0 / 360.0);
    for (size_t sample = 0; sample < samples; sample++) {
        double position = (double)sample * (choices & CHOICE_BACKWARD ? -step : step);
        int64_t counts = (int64_t)position;
        int64_t one = (int64_t)((int8_t)data[2 * sample] * most);
        int64_t two = (int64_t)((int8_t)data[2 * sample + 1] * most);
        fuzz.words[2 * sample] = (int32_t)(uint32_t)(counts + one);
        fuzz.words[2 * sample + 1] = (int32_t)(uint32_t)(counts + apart + two);
    }
    return (uint32_t)samples;
}

static uint32_t clipped(uint32_t value, uint32_t low, uint32_t high) {
    return low + value % (high - low + 1);
}

/* Limits the zero to half a turn in either direction. */
static int32_t zero_of(uint32_t word, uint32_t counts_per_rev) {
    return (int32_t)(word % counts_per_rev) - (int32_t)(counts_per_rev / 2);
}

static void judge(const struct capture *capture) {
    const struct estimate *estimate = &fuzz.estimate;
    require(estimate_is_finite(estimate));
    select_orders(estimate, LANES, GAIN_LIMIT_DEFAULT, fuzz.verdicts);
    enum refusal reason = coefficients_quantise(estimate, fuzz.verdicts, capture->counts_per_rev,
                                                LANES, &fuzz.coefficients);
    if (reason != NOT_REFUSED) {
        require(reason == REFUSED_AMPLITUDE);
        return;
    }
    for (uint32_t lane = 0; lane < LANES; lane++) {
        const struct lane *made = &fuzz.coefficients.lane[lane];
        require(made->amplitude >= 0 && made->amplitude < 1 << (ARCTRUE_AMPLITUDE_WIDTH - 1));
        require(made->phase_offset < 1U << ARCTRUE_PHASE_WIDTH);
        require(coefficients_phase_step(made->order, capture->counts_per_rev) >>
                    ARCTRUE_PHASE_STEP_WIDTH ==
                0);
    }
    struct gate_prediction prediction = gate_predict(estimate, NULL, &fuzz.coefficients);
    require(isfinite(prediction.active_arcsec) && isfinite(prediction.candidate_arcsec));
    reason = gate_judge(&prediction);
    require(reason == NOT_REFUSED || reason == REFUSED_NOT_BETTER);
}

static void calibrate(const struct capture *capture, struct turn *turn,
                      const struct calibration_settings *settings) {
    double apart_rad = turn_align(turn, settings->nominal_separation_rad);
    require(fabs(apart_rad - settings->nominal_separation_rad) <= PI * (1.0 + 1e-9));
    enum refusal reason =
        least_squares_estimate(&fuzz.least_squares, turn, settings, &fuzz.estimate);
    if (reason == NOT_REFUSED) {
        judge(capture);
    }
    reason = fourier_estimate(&fuzz.fourier, turn, settings, &fuzz.estimate);
    if (reason == NOT_REFUSED) {
        estimate_as_function_of_reading(&fuzz.reading, &fuzz.estimate);
        judge(capture);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    if (size < HEADER_BYTES) {
        return 0;
    }
    unsigned choices = data[0];
    uint32_t counts_per_rev =
        clipped(word_of(data + 2), ARCTRUE_COUNTS_PER_REV_MIN, ARCTRUE_COUNTS_PER_REV_MAX);
    const uint8_t *rest = data + HEADER_BYTES;
    struct capture capture = {
        .words = fuzz.words,
        .samples = choices & CHOICE_EVEN
                       ? fill_even(rest, size - HEADER_BYTES, counts_per_rev, choices)
                       : fill_words(rest, size - HEADER_BYTES),
        .flags = choices & CHOICE_EVEN ? 3U : (uint32_t)(data[6] | data[7] << 8),
        .counts_per_rev = counts_per_rev,
        .period_clocks = choices & CHOICE_EVEN ? 0 : word_of(data + 8),
        .angle_offset = word_of(data + 12) % counts_per_rev,
        .head2_zero = choices & CHOICE_EVEN ? zero_of(word_of(data + 8), counts_per_rev) : 0,
        .clock_hz = 100000000,
    };
    struct calibration_settings settings = {
        .nominal_separation_rad = 33.0 * PI / 180.0,
        .separation = choices & CHOICE_NOMINAL ? SEPARATION_NOMINAL : SEPARATION_AUTOMATIC,
        .orders = clipped(data[1], 1, ORDERS_MAX),
    };
    struct turn turn;
    struct capture_fault fault;
    enum refusal reason = capture_verify(&capture, settings.orders, &turn, &fault);
    require((unsigned)reason < REFUSALS);
    require(fault.sample <= capture.samples && fault.head <= 2);
    if (reason == NOT_REFUSED) {
        require(turn.samples > 0 && turn.samples <= capture.samples);
        calibrate(&capture, &turn, &settings);
    }
    return 0;
}
