// SPDX-License-Identifier: Apache-2.0
//
// Compares a design with the netlist that was decoded from its bitstream. Both get the same random levels and, if a
// list of accesses is given, the same accesses; the bench compares all outputs before and after every rising edge. It
// prints a line for each of the first SHOWN differences, for each block and for each output that did not change, and a
// last line with counts. Exit code 1: an output differs. 2: the arguments are wrong, or an access has no answer. The
// generated file lines.h describes inputs and outputs.

#include <cinttypes>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <vector>

#include "Vbench.h"
#include "axi_master.h"
#include "levels.h"
#include "lines.h"
#include "verilated.h"

namespace {

constexpr int SHOWN = 5;
constexpr uint64_t RESET_CLOCKS = 16;
constexpr uint64_t CLOCKS_A_RESET = 40000; // mean number of clocks from one reset to the next
constexpr uint32_t COUNTS_A_TURN = 96;

constexpr int FARTHEST = 100; // in counts, more than a turn

// Simulates an encoder. A turn has few counts, so that the index comes often. Sometimes the encoder jumps by several
// counts, which gives lost counts and illegal transitions. It turns back at FARTHEST on either side, so that positions
// of both signs occur again and again.
struct Encoder {
    uint32_t count = 0;
    int place = 0;
    uint32_t wait = 0;
    int direction = 1;

    void step() {
        if (wait > 0) {
            --wait;
            return;
        }
        if (one_in(100)) {
            direction = -direction;
        }
        if (place * direction > FARTHEST) {
            direction = -direction;
        }
        const uint32_t counts = one_in(400) ? 1 + static_cast<uint32_t>(any() % 5) : 1;
        count = (count + COUNTS_A_TURN + static_cast<uint32_t>(direction) * counts) % COUNTS_A_TURN;
        place += direction * static_cast<int>(counts);
        wait = static_cast<uint32_t>(one_in(4) ? any() % 200 : 12 + any() % 20);
    }
    bool a() const {
        return ((count + 1) & 2) != 0;
    }
    bool b() const {
        return (count & 2) != 0;
    }
    bool z() const {
        return count == 0;
    }
};

// Returns a random number in which every number of used bits is equally likely, because a register may accept small
// numbers only.
uint64_t of_any_size(int bits) {
    const int used = 1 + static_cast<int>(any() % static_cast<uint64_t>(bits));
    uint64_t value = any() & ((uint64_t{1} << used) - 1);
    if (one_in(4)) {
        value |= ~((uint64_t{1} << used) - 1); // a negative number of small magnitude
    }
    return value;
}

// Simulates an input that keeps each level for a random number of clocks, at most 60.
struct Pulse {
    bool level = false;
    uint32_t wait = 0;

    bool step() {
        if (wait-- == 0) {
            level = !level;
            wait = static_cast<uint32_t>(any() % 60);
        }
        return level;
    }
};

template <typename Bus>
void drive(Bus &inputs, uint64_t clock, std::vector<Encoder> &encoders, std::vector<Pulse> &pulses,
           const Master *master) {
    for (auto &encoder : encoders) {
        encoder.step();
    }
    size_t pulse = 0;
    for (const Line &line : LINES) {
        if (master != nullptr && line.is_master) {
            continue;
        }
        uint64_t value = 0;
        switch (line.kind) {
        case Kind::clock:
            continue;
        case Kind::resetn:
            value = ~uint64_t{0};
            if (clock < RESET_CLOCKS ||
                (master != nullptr ? master->resets() : one_in(CLOCKS_A_RESET))) {
                value = 0;
            }
            break;
        case Kind::pulse:
            value = pulses[pulse++].step();
            break;
        case Kind::valid:
            value = any() & 1;
            break;
        case Kind::ready:
            value = !one_in(4);
            break;
        case Kind::address:
            value = 0x40000000u | (of_any_size(18) & 0x3FFFCu);
            break;
        case Kind::strobe:
            value = one_in(16) ? any() : ~uint64_t{0};
            break;
        case Kind::length:
            value = one_in(16) ? any() & 3 : 0;
            break;
        case Kind::size:
            value = one_in(64) ? any() : 2;
            break;
        case Kind::burst:
            value = one_in(64) ? any() : 1;
            break;
        case Kind::last:
            value = !one_in(64);
            break;
        case Kind::data:
            value = of_any_size(line.bits);
            break;
        case Kind::encoder_a:
            value = encoders[line.encoder].a();
            break;
        case Kind::encoder_b:
            value = encoders[line.encoder].b();
            break;
        case Kind::encoder_z:
            value = encoders[line.encoder].z();
            break;
        }
        put(inputs, line.first, line.bits, value);
    }
}

} // namespace

int main(int count, char **words) {
    if (count != 3 && count != 5) {
        std::fprintf(stderr, "usage: bench clocks seed [accesses answers]\n");
        return 2;
    }
    const uint64_t clocks = std::strtoull(words[1], nullptr, 10);
    state = std::strtoull(words[2], nullptr, 10);
    const auto context = std::make_unique<VerilatedContext>();
    const auto bench = std::make_unique<Vbench>(context.get());
    std::vector<Encoder> encoders(ENCODERS);
    std::vector<Pulse> pulses(PULSES);
    std::unique_ptr<Master> master;
    if (count == 5) {
        master = std::make_unique<Master>(read_accesses(words[3]), words[4]);
    }
    std::vector<uint32_t> ones(ACTIVITY_WORDS, 0), zeros(ACTIVITY_WORDS, 0);
    std::vector<uint32_t> out_ones(OUTPUT_WORDS, 0), out_zeros(OUTPUT_WORDS, 0);
    int shown = 0;
    uint64_t different = 0;

    auto settle = [&](uint64_t clock, int level) {
        put(bench->inputs, CLOCK_LINE, 1, static_cast<uint64_t>(level));
        bench->eval();
        for (int word = 0; word < OUTPUT_WORDS; ++word) {
            const uint32_t expected = bench->expected[word];
            out_ones[static_cast<size_t>(word)] |= expected;
            out_zeros[static_cast<size_t>(word)] |= ~expected;
            if (expected == bench->found[word]) {
                continue;
            }
            ++different;
            for (int bit = 0; bit < 32 && shown < SHOWN; ++bit) {
                const int place = word * 32 + bit;
                if (get(bench->expected, place) == get(bench->found, place)) {
                    continue;
                }
                ++shown;
                std::printf("clock %" PRIu64 ": %s is %d, expected %d\n", clock, OUTPUTS[place],
                            get(bench->found, place), get(bench->expected, place));
            }
        }
    };

    uint64_t clock = 0;
    for (; clock < clocks || (master && !master->is_done()); ++clock) {
        drive(bench->inputs, clock, encoders, pulses, master.get());
        if (master) {
            if (master->hangs()) {
                std::fprintf(stderr, "access %zu has no answer\n", master->place());
                return 2;
            }
            master->drive(bench->inputs);
        }
        for (int word = 0; word < OPEN_WORDS; ++word) {
            bench->open_lines[word] = static_cast<uint32_t>(any());
        }
        settle(clock, 0);
        if (master) {
            master->take(bench->expected);
        }
        settle(clock, 1);
        for (int word = 0; word < ACTIVITY_WORDS; ++word) {
            ones[static_cast<size_t>(word)] |= bench->activity[word];
            zeros[static_cast<size_t>(word)] |= ~bench->activity[word];
        }
    }

    int moved = 0;
    for (const Block &block : BLOCKS) {
        bool has_moved = false;
        for (int place = block.first; place < block.first + block.bits; ++place) {
            has_moved |= get(ones, place) && get(zeros, place);
        }
        moved += has_moved;
        if (!has_moved) {
            std::printf("still: %s\n", block.name);
        }
    }
    int moved_outputs = 0;
    for (int place = 0; place < OUTPUT_COUNT; ++place) {
        const bool has_moved = get(out_ones, place) && get(out_zeros, place);
        moved_outputs += has_moved;
        if (!has_moved) {
            std::printf("quiet: %s\n", OUTPUTS[place]);
        }
    }
    std::printf("clocks=%" PRIu64 " different=%" PRIu64
                " outputs=%d moved_outputs=%d blocks=%d moved_blocks=%d\n",
                clock, different, OUTPUT_COUNT, moved_outputs, BLOCK_COUNT, moved);
    return different != 0;
}
