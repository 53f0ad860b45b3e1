// SPDX-License-Identifier: Apache-2.0

// An AXI4-Lite master for one access at a time, which can delay every channel at random.

#ifndef ARCTRUE_INSTRUMENT_BUS_H
#define ARCTRUE_INSTRUMENT_BUS_H

#include <cstdint>
#include <random>

#include "Varctrue_core.h"

namespace instrument {

class Bus {
  public:
    enum Response { OKAY = 0 };

    explicit Bus(Varctrue_core &core);
    void stall(uint32_t most_clocks, uint64_t seed);
    void begin_read(uint32_t address);
    void begin_write(uint32_t address, uint32_t word);
    // Order in each clock: drive() sets the channels, the clock falls, see() reads the handshakes, the clock rises.
    void drive();
    void see();
    void silence();

    bool busy = false;
    int response = OKAY;
    uint32_t data = 0;

  private:
    void begin();
    uint32_t wait();

    Varctrue_core &core;
    std::mt19937_64 random;
    uint32_t most_wait = 0;
    bool writing = false;
    bool address_done = false, data_done = false;
    uint32_t address_wait = 0, data_wait = 0, answer_wait = 0;
    uint32_t address = 0;
};

} // namespace instrument

#endif
