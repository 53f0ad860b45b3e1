// SPDX-License-Identifier: Apache-2.0

#include "harness.h"

#include <cmath>

// Name of the port `interrupt` in the C++ model; the build defines another name if Verilator renames the port.
#ifndef INTERRUPT_PORT
#define INTERRUPT_PORT interrupt
#endif

namespace instrument {

// Clocks after which an access without a response fails; much longer than any delay that a test sets.
static constexpr int64_t BUS_PATIENCE_CLOCKS = 100000;

Harness::Harness() : core(&context), bus(core) {
    context.fatalOnError(false);
    core.clock = 0;
    core.reset = 0;
    core.head1_a = core.head1_b = core.head1_z = 0;
    core.head2_a = core.head2_b = core.head2_z = 0;
    core.head3_a = core.head3_b = core.head3_z = 0;
    core.head4_a = core.head4_b = core.head4_z = 0;
    core.sync_in = core.probe_in = 0;
    bus.silence();
    core.eval();
}

bool Harness::step() {
    uint16_t pins = 0;
    if (!stimulus.advance(clock, &pins)) {
        message = stimulus.message;
        return false;
    }
    core.head1_a = pins & 1;
    core.head1_b = pins >> 1 & 1;
    core.head1_z = pins >> 2 & 1;
    core.head2_a = pins >> 3 & 1;
    core.head2_b = pins >> 4 & 1;
    core.head2_z = pins >> 5 & 1;
    core.sync_in = pins >> 6 & 1;
    core.probe_in = pins >> 7 & 1;
    core.head3_a = pins >> 8 & 1;
    core.head3_b = pins >> 9 & 1;
    core.head3_z = pins >> 10 & 1;
    core.head4_a = pins >> 11 & 1;
    core.head4_b = pins >> 12 & 1;
    core.head4_z = pins >> 13 & 1;
    bus.drive();
    core.clock = 0;
    core.eval();
    bus.see();
    core.clock = 1;
    core.eval();
    auto out = static_cast<uint8_t>(core.out_a | core.out_b << 1 | core.out_z << 2);
    auto angle = [this](double instant) { return stimulus.true_angle(instant); };
    head1.see(clock, static_cast<uint8_t>(pins & 7), angle);
    output.see(clock, out, angle);
    if (trace.size() < trace_most) {
        auto beside = core.trigger_out | core.compare_out << 1;
        trace.push_back(static_cast<uint16_t>((pins & 63) | out << 6 | beside << 9));
    }
    clock++;
    return true;
}

RunEnd Harness::run(const Wish &wish) {
    int64_t last = clock + wish.clocks;
    bool by_angle = std::isfinite(wish.true_angle) && stimulus.has_curves();
    double apart = 0.0;
    while (clock < last) {
        if (wish.stimulus_end && stimulus.ended(clock)) {
            return STIMULUS_END;
        }
        if (!step()) {
            return FAILED;
        }
        if (wish.interrupt && interrupt_line()) {
            return INTERRUPT;
        }
        if (by_angle) {
            double now = stimulus.true_angle(static_cast<double>(clock - 1)) - wish.true_angle;
            if (now == 0.0 || now * apart < 0.0) {
                return TRUE_ANGLE;
            }
            apart = now;
        }
    }
    return CLOCKS;
}

int Harness::access(bool write, uint32_t address, uint32_t *word) {
    if (write) {
        bus.begin_write(address, *word);
    } else {
        bus.begin_read(address);
    }
    int64_t until = clock + BUS_PATIENCE_CLOCKS;
    while (bus.busy) {
        if (clock >= until) {
            bus.silence();
            message = "the core does not answer on the bus (address " + std::to_string(address) +
                      "); is the core held in reset?";
            return -1;
        }
        if (!step()) {
            bus.silence();
            return -1;
        }
    }
    *word = bus.data;
    return bus.response;
}

void Harness::hold_reset(bool held) {
    core.reset = held;
    bus.silence();
}

bool Harness::interrupt_line() {
    return core.INTERRUPT_PORT != 0;
}

} // namespace instrument
