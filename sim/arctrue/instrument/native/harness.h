// SPDX-License-Identifier: Apache-2.0

// Connects the compiled core to its clock, its bus, the stimulus of its heads and the recorder of its output.

#ifndef ARCTRUE_INSTRUMENT_HARNESS_H
#define ARCTRUE_INSTRUMENT_HARNESS_H

#include <cstdint>
#include <string>
#include <vector>

#include "bus.h"
#include "recorder.h"
#include "stimulus.h"

namespace instrument {

enum RunEnd { CLOCKS = 0, TRUE_ANGLE = 1, INTERRUPT = 2, STIMULUS_END = 3, FAILED = -1 };

struct Wish {
    int64_t clocks;
    double true_angle; // true angle that ends the run; NaN: none
    bool interrupt;
    bool stimulus_end;
};

class Harness {
    // The core is declared before the bus, which drives the core's ports.
    VerilatedContext context;
    Varctrue_core core;

  public:
    Harness();

    // Runs one clock; returns false if the run failed, see `message`.
    bool step();
    RunEnd run(const Wish &wish);
    // Returns the response of the bus; -1 if the run failed or no response comes.
    int access(bool write, uint32_t address, uint32_t *word);
    void hold_reset(bool held);
    bool interrupt_line();

    int64_t clock = 0; // number of rising edges since power-on
    Stimulus stimulus;
    Bus bus;
    Track output, head1;
    std::string message;
    // Levels after each clock: pins of heads 1 and 2 (bits 0 to 5), of the output (6 to 8), trigger_out (9) and
    // compare_out (10).
    std::vector<uint16_t> trace;
    size_t trace_most = 0;
};

} // namespace instrument

#endif
