// SPDX-License-Identifier: Apache-2.0

// Defines the C functions that Python calls. A function that can fail returns a code, which is negative after a
// failure; instrument_message() then returns the text. If the core answers an access to the bus with an error,
// instrument_read() and instrument_write() return its response, which is positive.

#include <cmath>
#include <cstring>
#include <new>

#include "harness.h"

using instrument::Disturbance;
using instrument::Harness;
using instrument::Piece;
using instrument::Stimulus;
using instrument::Track;
using instrument::Wish;

double sc_time_stamp() {
    return 0;
}

#define EXPORTED extern "C" __attribute__((visibility("default")))

EXPORTED Harness *instrument_new(void) {
    return new (std::nothrow) Harness();
}

EXPORTED void instrument_delete(Harness *harness) {
    delete harness;
}

EXPORTED const char *instrument_message(const Harness *harness) {
    return harness->message.c_str();
}

EXPORTED int64_t instrument_clock(const Harness *harness) {
    return harness->clock;
}

EXPORTED double instrument_true_angle(const Harness *harness) {
    return harness->stimulus.true_angle(static_cast<double>(harness->clock));
}

EXPORTED int instrument_interrupt(Harness *harness) {
    return harness->interrupt_line();
}

EXPORTED void instrument_hold_reset(Harness *harness, int held) {
    harness->hold_reset(held != 0);
}

EXPORTED int instrument_run(Harness *harness, int64_t clocks, double true_angle, int interrupt,
                            int stimulus_end) {
    return harness->run(Wish{clocks, true_angle, interrupt != 0, stimulus_end != 0});
}

EXPORTED int instrument_read(Harness *harness, uint32_t address, uint32_t *words, int64_t number,
                             uint32_t *failed_address) {
    for (int64_t place = 0; place < number; place++) {
        *failed_address = address + 4U * static_cast<uint32_t>(place);
        int response = harness->access(false, *failed_address, &words[place]);
        if (response != 0) {
            return response;
        }
    }
    return 0;
}

EXPORTED int instrument_write(Harness *harness, uint32_t address, const uint32_t *words,
                              int64_t number, uint32_t *failed_address) {
    for (int64_t place = 0; place < number; place++) {
        uint32_t word = words[place];
        *failed_address = address + 4U * static_cast<uint32_t>(place);
        int response = harness->access(true, *failed_address, &word);
        if (response != 0) {
            return response;
        }
    }
    return 0;
}

EXPORTED void instrument_stall(Harness *harness, uint32_t most_clocks, uint64_t seed) {
    harness->bus.stall(most_clocks, seed);
}

EXPORTED void instrument_attach_curves(Harness *harness, instrument::NeedPiece need, void *context,
                                       int64_t end_clock, int64_t counts_per_rev,
                                       int64_t index_width, double rounding, int may_jump) {
    Stimulus::Graduation lines{counts_per_rev, index_width, rounding, may_jump != 0};
    harness->stimulus.attach_curves(need, context, harness->clock, end_clock, lines);
}

EXPORTED void instrument_piece(Harness *harness, int64_t first_clock, int64_t knot_clocks,
                               int64_t knots, int64_t heads, const double *curves) {
    Piece piece;
    piece.first_clock = first_clock;
    piece.knot_clocks = knot_clocks;
    for (int64_t row = 0; row <= heads; row++) {
        piece.curve.emplace_back(curves + row * knots, curves + (row + 1) * knots);
    }
    harness->stimulus.add_piece(std::move(piece));
}

EXPORTED void instrument_attach_events(Harness *harness, int64_t number, const int64_t *clocks,
                                       const uint8_t *levels, uint8_t first) {
    harness->stimulus.attach_events(std::vector<int64_t>(clocks, clocks + number),
                                    std::vector<uint8_t>(levels, levels + number), first);
}

EXPORTED void instrument_detach(Harness *harness) {
    harness->stimulus.detach();
}

EXPORTED void instrument_disturb(Harness *harness, int64_t number, const Disturbance *all,
                                 uint64_t seed) {
    harness->stimulus.disturb(std::vector<Disturbance>(all, all + number), seed);
}

EXPORTED void instrument_record(Harness *harness, int64_t bins, int64_t every, int64_t most,
                                double counts_per_rev, double travel, double latency_clocks) {
    Track::Settings settings{bins, every, most, counts_per_rev, travel, latency_clocks + 0.5};
    harness->output.start(settings);
    settings.age_clocks = 0.5;
    harness->head1.start(settings);
}

EXPORTED void instrument_stop_recording(Harness *harness) {
    harness->output.stop();
    harness->head1.stop();
}

struct TrackView {
    int64_t position, edges, illegal, dropped, kept, bins, indices;
    const int64_t *kept_clock, *kept_position;
    const double *kept_angle;
    const int64_t *bin_edges;
    const double *bin_sum, *bin_lowest, *bin_highest;
    const int64_t *index_clock, *index_position;
};

EXPORTED void instrument_track(const Harness *harness, int which, TrackView *view) {
    const Track &track = which ? harness->head1 : harness->output;
    *view = TrackView{track.position,
                      track.edges,
                      track.illegal,
                      track.dropped,
                      static_cast<int64_t>(track.kept_clock.size()),
                      static_cast<int64_t>(track.bin_edges.size()),
                      static_cast<int64_t>(track.index_clock.size()),
                      track.kept_clock.data(),
                      track.kept_position.data(),
                      track.kept_angle.data(),
                      track.bin_edges.data(),
                      track.bin_sum.data(),
                      track.bin_lowest.data(),
                      track.bin_highest.data(),
                      track.index_clock.data(),
                      track.index_position.data()};
}

EXPORTED void instrument_trace(Harness *harness, int64_t most) {
    harness->trace.clear();
    harness->trace_most = static_cast<size_t>(most);
}

EXPORTED int64_t instrument_traced(const Harness *harness, const uint16_t **levels) {
    *levels = harness->trace.data();
    return static_cast<int64_t>(harness->trace.size());
}

// Bus of the firmware. The firmware cannot handle a bus error, so the first error is stored for Python.
struct FirmwareBus {
    Harness *harness;
    int64_t accesses;
    int64_t calculation_clocks;
    int first_response;
    uint32_t first_address;
    std::vector<int32_t> *bank;
    std::vector<int32_t> *further_bank;
};

static void keep(FirmwareBus *bus, int response, uint32_t address) {
    bus->accesses++;
    if (response != 0 && bus->first_response == 0) {
        bus->first_response = response;
        bus->first_address = address;
    }
}

EXPORTED FirmwareBus *firmware_bus_new(Harness *harness) {
    return new (std::nothrow)
        FirmwareBus{harness, 0, 0, 0, 0, new std::vector<int32_t>(), new std::vector<int32_t>()};
}

EXPORTED void firmware_bus_delete(FirmwareBus *bus) {
    delete bus->bank;
    delete bus->further_bank;
    delete bus;
}

EXPORTED uint32_t firmware_bus_read(void *context, uint32_t offset) {
    auto *bus = static_cast<FirmwareBus *>(context);
    uint32_t word = 0;
    keep(bus, bus->harness->access(false, offset, &word), offset);
    return word;
}

EXPORTED void firmware_bus_write(void *context, uint32_t offset, uint32_t word) {
    auto *bus = static_cast<FirmwareBus *>(context);
    keep(bus, bus->harness->access(true, offset, &word), offset);
}

// Reads every `stride`th word of a bank; the words between them stay 0.
static const volatile int32_t *read_bank(void *context, std::vector<int32_t> *bank, uint32_t first,
                                         uint32_t number, uint32_t stride) {
    bank->assign(number, 0);
    for (uint32_t place = 0; place < number; place += stride) {
        uint32_t word = firmware_bus_read(context, first + 4U * place);
        std::memcpy(&(*bank)[place], &word, sizeof word);
    }
    return bank->data();
}

// Reads the capture bank word by word over the bus, then runs the core for the clocks that the processor needs for
// the calculation.
EXPORTED const volatile int32_t *firmware_bus_capture(void *context, uint32_t number) {
    static const uint32_t CAPTURE = CAPTURE_ADDRESS;
    auto *bus = static_cast<FirmwareBus *>(context);
    read_bank(context, bus->bank, CAPTURE, number, 1U);
    if (bus->harness->run(Wish{bus->calculation_clocks, std::nan(""), false, false}) < 0) {
        keep(bus, -1, 0);
    }
    return bus->bank->data();
}

// Reads the bank of heads 3 and 4; a core with three heads refuses the words of head 4, and the firmware does not use
// them.
EXPORTED const volatile int32_t *firmware_bus_further_capture(void *context, uint32_t number) {
    static const uint32_t FURTHER_CAPTURE = FURTHER_CAPTURE_ADDRESS;
    static const uint32_t STRIDE = BUILT_HEADS == 3 ? 2U : 1U;
    return read_bank(context, static_cast<FirmwareBus *>(context)->further_bank, FURTHER_CAPTURE,
                     number, STRIDE);
}
