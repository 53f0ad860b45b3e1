// SPDX-License-Identifier: Apache-2.0
//
// Acts as the processor's AXI3 master at M_AXI_GP0 and makes the accesses of a list. VALID stays high until READY is
// high, address and data of a write come in either order, and the master accepts an answer after a random time. While
// VALID of a channel is low, the other signals of the channel get random levels. scripts/bitstream_stimulus.py makes
// the list, and scripts/bitstream_equality.py writes it into a file.

#pragma once

#include <cinttypes>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "levels.h"
#include "lines.h"

struct Access {
    char kind; // w: write, r: read, n: no access for `data` clocks, z: reset for `data` clocks
    uint32_t address;
    uint32_t data; // data of the first beat; the data of each further beat are larger by BEAT_STEP
    int beats;
    uint64_t size;
    uint64_t burst;
    uint64_t strobe;
    int last;     // number of the beat at which WLAST is high
    int together; // 1: the access may start during an access in the other direction
};

constexpr uint32_t BEAT_STEP = 0x01000193;

// Reads a file with one access per line; a line has the fields of Access in their order.
inline std::vector<Access> read_accesses(const char *path) {
    std::vector<Access> found;
    std::FILE *file = std::fopen(path, "r");
    if (file == nullptr) {
        std::fprintf(stderr, "%s cannot be read\n", path);
        std::exit(2);
    }
    Access one{};
    while (std::fscanf(file,
                       " %c %" SCNx32 " %" SCNx32 " %d %" SCNu64 " %" SCNu64 " %" SCNu64 " %d %d",
                       &one.kind, &one.address, &one.data, &one.beats, &one.size, &one.burst,
                       &one.strobe, &one.last, &one.together) == 9) {
        found.push_back(one);
    }
    std::fclose(file);
    return found;
}

// State of a channel that this master drives: VALID and its payload.
struct Offer {
    bool is_due = false;   // an address or a beat waits for its handshake
    bool is_shown = false; // VALID is high

    bool decide() {
        is_shown = is_due && (is_shown || one_in(2));
        return is_shown;
    }
    bool taken(bool ready) {
        const bool done = is_shown && ready;
        if (done) {
            is_shown = false;
        }
        return done;
    }
};

class Master {
  public:
    Master(std::vector<Access> accesses, const char *answers)
        : accesses_(std::move(accesses)), answers_(std::fopen(answers, "w")) {
        if (answers_ == nullptr) {
            std::fprintf(stderr, "%s cannot be written\n", answers);
            std::exit(2);
        }
    }
    ~Master() {
        std::fclose(answers_);
    }
    Master(const Master &) = delete;
    Master &operator=(const Master &) = delete;

    bool is_done() const {
        return next_ == accesses_.size() && !is_busy();
    }
    bool resets() const {
        return reset_clocks_ > 0;
    }
    bool hangs() const {
        return waited_ > LONGEST_ACCESS;
    }
    size_t place() const {
        return next_;
    }

    // Sets the levels of all signals for the next clock.
    template <typename Bus> void drive(Bus &inputs) {
        start();
        write_address_.decide();
        write_data_.decide();
        read_address_.decide();
        takes_write_ = !one_in(4);
        takes_read_ = !one_in(4);
        offer(inputs, write_address_.is_shown, AXI.awvalid, AXI.awaddr, write_.address, AXI.awlen,
              static_cast<uint64_t>(write_.beats - 1), AXI.awsize, write_.size, AXI.awburst,
              write_.burst, AXI.awid, write_id_);
        offer(inputs, read_address_.is_shown, AXI.arvalid, AXI.araddr, read_.address, AXI.arlen,
              static_cast<uint64_t>(read_.beats - 1), AXI.arsize, read_.size, AXI.arburst,
              read_.burst, AXI.arid, read_id_);
        const bool valid = write_data_.is_shown;
        set(inputs, AXI.wvalid, valid);
        set(inputs, AXI.wdata,
            valid ? write_.data + static_cast<uint32_t>(beat_) * BEAT_STEP : any());
        set(inputs, AXI.wstrb, valid ? write_.strobe : any());
        set(inputs, AXI.wlast, valid ? beat_ == write_.last : any());
        set(inputs, AXI.bready, takes_write_);
        set(inputs, AXI.rready, takes_read_);
    }

    // Finds the handshakes of this clock in the outputs that are read before the clock edge.
    template <typename Bus> void take(const Bus &outputs) {
        if (reset_clocks_ > 0) {
            --reset_clocks_;
        }
        if (idle_clocks_ > 0) {
            --idle_clocks_;
        }
        if (is_writing_ || is_reading_) {
            ++waited_;
        }
        if (write_address_.taken(get(outputs, AXI.awready))) {
            write_address_.is_due = false;
        }
        if (write_data_.taken(get(outputs, AXI.wready))) {
            write_data_.is_due = ++beat_ < write_.beats;
        }
        if (read_address_.taken(get(outputs, AXI.arready))) {
            read_address_.is_due = false;
        }
        if (is_writing_ && takes_write_ && get(outputs, AXI.bvalid)) {
            is_writing_ = false;
            answer(write_place_, value(outputs, AXI.bresp, 2), 0);
        }
        if (is_reading_ && takes_read_ && get(outputs, AXI.rvalid)) {
            is_reading_ = !get(outputs, AXI.rlast);
            answer(read_place_, value(outputs, AXI.rresp, 2), value(outputs, AXI.rdata, 32));
        }
    }

  private:
    static constexpr uint64_t LONGEST_ACCESS = 5000;

    bool is_busy() const {
        return is_writing_ || is_reading_ || idle_clocks_ > 0 || reset_clocks_ > 0;
    }

    void start() {
        if (next_ == accesses_.size() || idle_clocks_ > 0 || reset_clocks_ > 0) {
            return;
        }
        const Access &one = accesses_[next_];
        const bool is_in_the_way = one.kind == 'w'   ? is_writing_
                                   : one.kind == 'r' ? is_reading_
                                                     : is_busy();
        if (is_in_the_way || (is_busy() && !one.together)) {
            return;
        }
        if (one.kind == 'w') {
            write_ = one;
            write_place_ = next_;
            write_id_ = any();
            beat_ = 0;
            is_writing_ = write_address_.is_due = write_data_.is_due = true;
        } else if (one.kind == 'r') {
            read_ = one;
            read_place_ = next_;
            read_id_ = any();
            is_reading_ = read_address_.is_due = true;
        } else if (one.kind == 'n') {
            idle_clocks_ = one.data;
        } else {
            reset_clocks_ = one.data;
        }
        ++next_;
    }

    template <typename Bus> static void set(Bus &inputs, Lines lines, uint64_t value) {
        put(inputs, lines.first, lines.bits, value);
    }

    template <typename Bus>
    static void offer(Bus &inputs, bool valid, Lines valid_line, Lines address,
                      uint64_t address_value, Lines length, uint64_t length_value, Lines size,
                      uint64_t size_value, Lines burst, uint64_t burst_value, Lines id,
                      uint64_t id_value) {
        set(inputs, valid_line, valid);
        set(inputs, address, valid ? address_value : any());
        set(inputs, length, valid ? length_value : any());
        set(inputs, size, valid ? size_value : any());
        set(inputs, burst, valid ? burst_value : any());
        set(inputs, id, valid ? id_value : any());
    }

    template <typename Bus> static uint32_t value(const Bus &outputs, Lines lines, int bits) {
        uint32_t found = 0;
        for (int bit = 0; bit < bits; ++bit) {
            found |= static_cast<uint32_t>(get(outputs, lines.first + bit)) << bit;
        }
        return found;
    }

    template <typename Bus> static bool get(const Bus &outputs, Lines lines) {
        return ::get(outputs, lines.first);
    }
    template <typename Bus> static bool get(const Bus &outputs, int place) {
        return ::get(outputs, place);
    }

    void answer(size_t place, uint32_t response, uint32_t data) {
        waited_ = 0;
        std::fprintf(answers_, "%zu %" PRIu32 " %" PRIx32 "\n", place, response, data);
    }

    std::vector<Access> accesses_;
    std::FILE *answers_;
    size_t next_ = 0;
    Access write_{};
    Access read_{};
    size_t write_place_ = 0;
    size_t read_place_ = 0;
    uint64_t write_id_ = 0;
    uint64_t read_id_ = 0;
    int beat_ = 0;
    bool is_writing_ = false;
    bool is_reading_ = false;
    bool takes_write_ = false;
    bool takes_read_ = false;
    Offer write_address_;
    Offer write_data_;
    Offer read_address_;
    uint64_t idle_clocks_ = 0;
    uint64_t reset_clocks_ = 0;
    uint64_t waited_ = 0;
};
