// SPDX-License-Identifier: Apache-2.0

#include "bus.h"

namespace instrument {

Bus::Bus(Varctrue_core &driven) : core(driven) {
    silence();
}

void Bus::stall(uint32_t most_clocks, uint64_t seed) {
    most_wait = most_clocks;
    random.seed(seed);
}

uint32_t Bus::wait() {
    return most_wait ? static_cast<uint32_t>(random() % (most_wait + 1U)) : 0U;
}

void Bus::begin() {
    busy = true;
    address_done = data_done = false;
    address_wait = wait();
    data_wait = wait();
    answer_wait = wait();
}

void Bus::begin_read(uint32_t where) {
    writing = false;
    address = where;
    begin();
}

void Bus::begin_write(uint32_t where, uint32_t word) {
    writing = true;
    address = where;
    data = word;
    begin();
}

void Bus::silence() {
    busy = false;
    core.s_axil_request_awvalid = core.s_axil_request_wvalid = core.s_axil_request_bready = 0;
    core.s_axil_request_arvalid = core.s_axil_request_rready = 0;
    core.s_axil_request_awaddr = core.s_axil_request_araddr = 0;
    core.s_axil_request_wdata = 0;
    core.s_axil_request_wstrb = 0;
}

// Sets the channels. AXI requires that a valid signal stays high until its handshake; the signals do, because the
// wait counters only count down.
void Bus::drive() {
    bool asks = busy && !address_done && address_wait == 0;
    bool gives = busy && writing && !data_done && data_wait == 0;
    bool takes = busy && answer_wait == 0;
    core.s_axil_request_awvalid = asks && writing;
    core.s_axil_request_arvalid = asks && !writing;
    core.s_axil_request_wvalid = gives;
    core.s_axil_request_bready = takes && writing;
    core.s_axil_request_rready = takes && !writing;
    if (asks) {
        (writing ? core.s_axil_request_awaddr : core.s_axil_request_araddr) = address;
    }
    if (gives) {
        core.s_axil_request_wdata = data;
        core.s_axil_request_wstrb = 0xF;
    }
    address_wait -= address_wait > 0;
    data_wait -= data_wait > 0;
    answer_wait -= answer_wait > 0;
}

void Bus::see() {
    if (!busy) {
        return;
    }
    if (writing) {
        address_done =
            address_done || (core.s_axil_request_awvalid && core.s_axil_response_awready);
        data_done = data_done || (core.s_axil_request_wvalid && core.s_axil_response_wready);
        if (core.s_axil_response_bvalid && core.s_axil_request_bready) {
            response = core.s_axil_response_bresp;
            busy = false;
        }
    } else {
        address_done =
            address_done || (core.s_axil_request_arvalid && core.s_axil_response_arready);
        if (core.s_axil_response_rvalid && core.s_axil_request_rready) {
            response = core.s_axil_response_rresp;
            data = core.s_axil_response_rdata;
            busy = false;
        }
    }
}

} // namespace instrument
