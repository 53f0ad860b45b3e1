// SPDX-License-Identifier: Apache-2.0

#include "stimulus.h"

#include <cmath>
#include <limits>
#include <utility>

namespace instrument {

uint8_t pins_of_count(int64_t count, int64_t counts_per_rev, int64_t index_width) {
    static const uint8_t quadrature[4] = {0, 1, 3, 2};
    int64_t in_turn = count % counts_per_rev;
    in_turn += in_turn < 0 ? counts_per_rev : 0;
    return static_cast<uint8_t>(quadrature[count & 3] | (in_turn < index_width ? 4 : 0));
}

int quadrature_step(uint8_t before, uint8_t after) {
    static const int phase[4] = {0, 1, 3, 2};
    int step = (phase[after & 3] - phase[before & 3]) & 3;
    return step == 3 ? -1 : step;
}

int64_t Piece::intervals() const {
    return static_cast<int64_t>(curve[0].size()) - 3;
}

int64_t Piece::end_clock() const {
    return first_clock + intervals() * knot_clocks;
}

bool Piece::holds(double clock) const {
    return clock >= static_cast<double>(first_clock) && clock <= static_cast<double>(end_clock());
}

// Computes Lagrange's cubic through the knots -1, 0, 1 and 2, in powers of the fraction of the interval.
static void lagrange(const double *knot, double *power) {
    power[0] = knot[1];
    power[1] = -knot[0] / 3 - knot[1] / 2 + knot[2] - knot[3] / 6;
    power[2] = (knot[0] + knot[2]) / 2 - knot[1];
    power[3] = (knot[3] - knot[0]) / 6 + (knot[1] - knot[2]) / 2;
}

static double horner(const double *power, double share) {
    return ((power[3] * share + power[2]) * share + power[1]) * share + power[0];
}

double Piece::at(int which, double clock) const {
    double knots = (clock - static_cast<double>(first_clock)) / static_cast<double>(knot_clocks);
    auto interval = static_cast<int64_t>(std::floor(knots));
    interval = std::min(std::max<int64_t>(interval, 0), intervals() - 1);
    double power[4];
    lagrange(&curve[static_cast<size_t>(which)][static_cast<size_t>(interval)], power);
    return horner(power, knots - static_cast<double>(interval));
}

void Stimulus::attach_curves(NeedPiece wanted, void *context, int64_t, int64_t end,
                             const Graduation &lines) {
    detach();
    kind = CURVES;
    need = wanted;
    need_context = context;
    end_clock = end;
    graduation = lines;
    has_present = has_last = counted = false;
    interval_first = interval_end = 0;
}

void Stimulus::add_piece(Piece piece) {
    last = std::move(present);
    has_last = has_present;
    present = std::move(piece);
    has_present = true;
}

void Stimulus::attach_events(std::vector<int64_t> clocks, std::vector<uint8_t> levels,
                             uint8_t first) {
    detach();
    kind = EVENTS;
    event_clocks = std::move(clocks);
    event_levels = std::move(levels);
    next_event = 0;
    undisturbed = first;
    end_clock = event_clocks.empty() ? 0 : event_clocks.back() + 1;
}

void Stimulus::detach() {
    kind = NOTHING;
    need = nullptr;
}

void Stimulus::disturb(std::vector<Disturbance> wanted, uint64_t seed) {
    disturbances = std::move(wanted);
    random.seed(seed);
}

bool Stimulus::advance(int64_t clock, uint16_t *levels) {
    if (kind == CURVES && clock < end_clock && !follow_curves(clock)) {
        return false;
    }
    if (kind == EVENTS) {
        follow_events(clock);
    }
    *levels = disturbances.empty() ? undisturbed : disturbed(clock);
    return true;
}

double Stimulus::true_angle(double clock) const {
    clock = std::min(clock, static_cast<double>(end_clock));
    if (kind == CURVES && has_present && present.holds(clock)) {
        return present.at(present.heads(), clock);
    }
    if (kind == CURVES && has_last && last.holds(clock)) {
        return last.at(last.heads(), clock);
    }
    return std::numeric_limits<double>::quiet_NaN();
}

bool Stimulus::next_piece(int64_t clock) {
    if (need(need_context, clock) != 0 || !has_present || clock < present.first_clock ||
        clock >= present.end_clock()) {
        message = "the stimulus gave no curves for clock " + std::to_string(clock);
        return false;
    }
    return true;
}

void Stimulus::load_interval(int64_t clock) {
    int64_t interval = (clock - present.first_clock) / present.knot_clocks;
    interval_first = present.first_clock + interval * present.knot_clocks;
    interval_end = interval_first + present.knot_clocks;
    for (int head = 0; head < present.heads(); head++) {
        lagrange(&present.curve[static_cast<size_t>(head)][static_cast<size_t>(interval)],
                 cubic[head]);
        cubic[head][0] += graduation.rounding;
    }
}

bool Stimulus::follow_curves(int64_t clock) {
    if (clock >= interval_end || clock < interval_first) {
        if ((!has_present || clock >= present.end_clock()) && !next_piece(clock)) {
            return false;
        }
        load_interval(clock);
    }
    double share =
        static_cast<double>(clock - interval_first) / static_cast<double>(present.knot_clocks);
    uint16_t levels = 0;
    for (int head = 0; head < present.heads(); head++) {
        auto now = static_cast<int64_t>(std::floor(horner(cubic[head], share)));
        if (counted && !graduation.may_jump && std::llabs(now - count[head]) > 1) {
            message = "head " + std::to_string(head + 1) + " makes " +
                      std::to_string(std::llabs(now - count[head])) + " counts in clock " +
                      std::to_string(clock) + ": turn the table slower or take more clocks a count";
            return false;
        }
        count[head] = now;
        levels |= static_cast<uint16_t>(
            pins_of_count(now, graduation.counts_per_rev, graduation.index_width)
            << pin_of_head(head));
    }
    counted = true;
    undisturbed = levels;
    return true;
}

void Stimulus::follow_events(int64_t clock) {
    while (next_event < event_clocks.size() && event_clocks[next_event] <= clock) {
        undisturbed = event_levels[next_event++];
    }
}

uint16_t Stimulus::disturbed(int64_t clock) {
    uint16_t levels = undisturbed;
    std::uniform_real_distribution<double> chance(0.0, 1.0);
    for (const Disturbance &one : disturbances) {
        if (clock < one.first_clock || clock >= one.first_clock + one.clocks) {
            continue;
        }
        if (one.probability >= 1.0 || chance(random) < one.probability) {
            levels = static_cast<uint16_t>(((levels & ~one.low) | one.high) ^ one.invert);
        }
    }
    return levels;
}

} // namespace instrument
