// SPDX-License-Identifier: Apache-2.0
//
// Reads one line and sets several lines of a bus that is stored in words of 32 bits, and draws random numbers.

#pragma once

#include <cstdint>

inline uint64_t state;

// Returns the next random number of the generator SplitMix64.
inline uint64_t any() {
    uint64_t value = (state += 0x9E3779B97F4A7C15u);
    value = (value ^ (value >> 30)) * 0xBF58476D1CE4E5B9u;
    value = (value ^ (value >> 27)) * 0x94D049BB133111EBu;
    return value ^ (value >> 31);
}

inline bool one_in(uint64_t count) {
    return any() % count == 0;
}

template <typename Bus> void put(Bus &bus, int first, int bits, uint64_t value) {
    for (int bit = 0; bit < bits; ++bit) {
        const int place = first + bit;
        const uint32_t mask = uint32_t{1} << (place % 32);
        if (value >> bit & 1) {
            bus[place / 32] |= mask;
        } else {
            bus[place / 32] &= ~mask;
        }
    }
}

template <typename Bus> bool get(const Bus &bus, int place) {
    return bus[place / 32] >> (place % 32) & 1;
}
