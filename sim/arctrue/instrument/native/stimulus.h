// SPDX-License-Identifier: Apache-2.0

// Sets the levels of the core's input pins. The pins of the heads follow either readings of two to four heads, given as
// curves over the clocks, or a given sequence of levels of the six pins of heads 1 and 2. Disturbances act on the wires
// between heads and core; the pins sync_in and probe_in change only by disturbances.

#ifndef ARCTRUE_INSTRUMENT_STIMULUS_H
#define ARCTRUE_INSTRUMENT_STIMULUS_H

#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "arctrue_number_formats.h"

namespace instrument {

constexpr int HEADS_MOST = ARCTRUE_HEADS_MAX;
constexpr int PINS_A_HEAD = 3;

// Levels of the pins: heads 1 and 2 in bits 0 to 5, sync_in 6, probe_in 7, heads 3 and 4 in 8 to 13.
constexpr int pin_of_head(int head) {
    return PINS_A_HEAD * head + (head < 2 ? 0 : 2);
}

// Levels of A (bit 0), B (bit 1) and Z (bit 2) at a count; A leads B while the count rises.
uint8_t pins_of_count(int64_t count, int64_t counts_per_rev, int64_t index_width);

// Returns the step of the count from one pair of levels of A and B to the next: -1, 0, 1; 2 is illegal.
int quadrature_step(uint8_t before, uint8_t after);

// Curves of each head and of the true angle over a range of clocks, given at knots. Between two knots, a cubic through
// the four nearest knots is used.
struct Piece {
    int64_t first_clock = 0;
    int64_t knot_clocks = 1;
    // Values at the knots, from one before `first_clock` to one after the end of the last interval.
    std::vector<std::vector<double>> curve;

    int heads() const {
        return static_cast<int>(curve.size()) - 1;
    }

    int64_t intervals() const;
    int64_t end_clock() const;
    bool holds(double clock) const;
    double at(int which, double clock) const;
};

// Disturbance that inverts or holds pins for some clocks; whether it acts is drawn at random in each clock.
struct Disturbance {
    int64_t first_clock;
    int64_t clocks;
    uint16_t invert;
    uint16_t low;
    uint16_t high;
    double probability;
};

using NeedPiece = int (*)(void *context, int64_t first_clock);

class Stimulus {
  public:
    struct Graduation {
        int64_t counts_per_rev = 4;
        int64_t index_width = 1;
        double rounding = 0.0; // added before the floor: 0.5 rounds to the nearest
        bool may_jump = false; // allow more than one count per clock
    };

    void attach_curves(NeedPiece need, void *context, int64_t first_clock, int64_t end_clock,
                       const Graduation &graduation);
    void add_piece(Piece piece);
    void attach_events(std::vector<int64_t> clocks, std::vector<uint8_t> levels, uint8_t first);
    void detach();
    void disturb(std::vector<Disturbance> disturbances, uint64_t seed);

    // Sets the levels of this clock; call it once per clock, in order. Returns false after a fault, see `message`.
    bool advance(int64_t clock, uint16_t *levels);

    bool has_curves() const {
        return kind == CURVES;
    }
    bool ended(int64_t clock) const {
        return kind != NOTHING && clock >= end_clock;
    }
    // Returns the true angle at an instant of the present or the previous piece, radians; NaN without curves.
    double true_angle(double clock) const;

    std::string message;

  private:
    enum Kind { NOTHING, CURVES, EVENTS };

    bool follow_curves(int64_t clock);
    bool next_piece(int64_t clock);
    void load_interval(int64_t clock);
    void follow_events(int64_t clock);
    uint16_t disturbed(int64_t clock);

    Kind kind = NOTHING;
    int64_t end_clock = 0;
    uint16_t undisturbed = 0;

    NeedPiece need = nullptr;
    void *need_context = nullptr;
    Graduation graduation;
    Piece present, last;
    bool has_present = false, has_last = false;
    bool counted = false;
    int64_t count[HEADS_MOST] = {};
    // Cubic of each head in the present interval, and the clocks at which this interval begins and ends.
    double cubic[HEADS_MOST][4] = {};
    int64_t interval_first = 0, interval_end = 0;

    std::vector<int64_t> event_clocks;
    std::vector<uint8_t> event_levels;
    size_t next_event = 0;

    std::vector<Disturbance> disturbances;
    std::mt19937_64 random;
};

} // namespace instrument

#endif
