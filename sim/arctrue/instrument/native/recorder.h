// SPDX-License-Identifier: Apache-2.0

// Decodes A, B and Z by the table of the quadrature code, independently of the gateware's decoder, and compares every
// edge with the true angle of the table.

#ifndef ARCTRUE_INSTRUMENT_RECORDER_H
#define ARCTRUE_INSTRUMENT_RECORDER_H

#include <cstdint>
#include <functional>
#include <vector>

namespace instrument {

// Records the edges of one encoder signal.
class Track {
  public:
    struct Settings {
        int64_t bins = 0;  // number of equal parts of the turn; 0: none
        int64_t every = 0; // N: every N-th edge is kept; 0: none
        int64_t most = 0;  // largest number of kept edges
        double counts_per_rev = 4;
        double travel = 0.0; // rotation in radians after which the recording ends; 0: never
        // Clocks from a change of the table to its edge; by default, the change is in the middle of a clock.
        double age_clocks = 0.5;
    };

    void start(const Settings &settings);
    void stop() {
        recording = false;
    }
    // Records the levels after a clock. `true_angle` returns the angle at an instant, NaN if unknown.
    void see(int64_t clock, uint8_t levels, const std::function<double(double)> &true_angle);

    int64_t position = 0;
    int64_t edges = 0;
    int64_t illegal = 0;
    int64_t dropped = 0; // edges that were not kept because of `most`
    std::vector<int64_t> kept_clock, kept_position, index_clock, index_position;
    std::vector<double> kept_angle;
    std::vector<int64_t> bin_edges;
    std::vector<double> bin_sum, bin_lowest, bin_highest;

  private:
    void note(int64_t clock, int64_t level, const std::function<double(double)> &true_angle);
    bool beyond(double angle);

    Settings settings;
    bool recording = false;
    double first_angle = 0.0;
    bool known = false;
    uint8_t before = 0;
};

} // namespace instrument

#endif
