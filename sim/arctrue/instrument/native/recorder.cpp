// SPDX-License-Identifier: Apache-2.0

#include "recorder.h"

#include <cmath>
#include <limits>

#include "stimulus.h"

namespace instrument {

static constexpr double TURN_RAD = 6.283185307179586476925286766559;
static constexpr size_t MOST_INDEX_EDGES = 1 << 20;

void Track::start(const Settings &wanted) {
    settings = wanted;
    recording = true;
    first_angle = std::numeric_limits<double>::quiet_NaN();
    edges = illegal = dropped = 0;
    kept_clock.clear();
    kept_position.clear();
    kept_angle.clear();
    index_clock.clear();
    index_position.clear();
    auto bins = static_cast<size_t>(settings.bins);
    bin_edges.assign(bins, 0);
    bin_sum.assign(bins, 0.0);
    bin_lowest.assign(bins, std::numeric_limits<double>::infinity());
    bin_highest.assign(bins, -std::numeric_limits<double>::infinity());
}

void Track::see(int64_t clock, uint8_t levels, const std::function<double(double)> &true_angle) {
    if (!known) {
        known = true;
        before = levels;
        return;
    }
    if (levels == before) {
        return;
    }
    int step = quadrature_step(before, levels);
    bool index_rises = (levels & ~before & 4) != 0;
    before = levels;
    if (step == 2) {
        illegal += recording;
        return;
    }
    position += step;
    if (!recording) {
        return;
    }
    if (index_rises && index_clock.size() < MOST_INDEX_EDGES) {
        index_clock.push_back(clock);
        index_position.push_back(position);
    }
    if (step != 0) {
        // A rising reading enters the count `position` at its lower end, a falling reading at its upper end.
        note(clock, step > 0 ? position : position + 1, true_angle);
    }
}

bool Track::beyond(double angle) {
    if (std::isnan(first_angle)) {
        first_angle = angle;
    }
    return std::fabs(angle - first_angle) >= settings.travel;
}

void Track::note(int64_t clock, int64_t level, const std::function<double(double)> &true_angle) {
    bool keep = settings.every > 0 && edges % settings.every == 0;
    if (!keep && settings.bins == 0 && settings.travel == 0.0) {
        edges++;
        return;
    }
    double angle = true_angle(static_cast<double>(clock) - settings.age_clocks);
    if (settings.travel > 0.0 && beyond(angle)) {
        recording = false;
        return;
    }
    edges++;
    if (keep) {
        if (static_cast<int64_t>(kept_clock.size()) < settings.most) {
            kept_clock.push_back(clock);
            kept_position.push_back(level);
            kept_angle.push_back(angle);
        } else {
            dropped++;
        }
    }
    if (settings.bins > 0 && std::isfinite(angle)) {
        double turns = angle / TURN_RAD;
        double error = static_cast<double>(level) - turns * settings.counts_per_rev;
        auto bin =
            static_cast<int64_t>((turns - std::floor(turns)) * static_cast<double>(settings.bins));
        auto place = static_cast<size_t>(bin < settings.bins ? bin : settings.bins - 1);
        bin_edges[place]++;
        bin_sum[place] += error;
        bin_lowest[place] = std::fmin(bin_lowest[place], error);
        bin_highest[place] = std::fmax(bin_highest[place], error);
    }
}

} // namespace instrument
