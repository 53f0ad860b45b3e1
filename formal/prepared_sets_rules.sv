// SPDX-License-Identifier: Apache-2.0
//
// A set is swapped whole: when the clock of its first angle comes, any word of the idle bank is the word of that set, and
// none changes while the swap waits. A swap takes place only while `may_activate` is high. Each write of the processor reaches the
// bank unchanged before it is acknowledged. The rules follow one arbitrary word of one set; of the memory only this
// word is modelled. Source: the entity's header.

module prepared_sets_rules #(
    parameter LANES = 1, parameter HEADS = 3
) (
    input clock, input reset,
    input access_read, input access_write, input [2:0] access_set, input [9:0] access_word,
    input [31:0] access_data,
    input write_lane, input write_offset, input write_mean, input [7:0] write_address,
    input [31:0] write_data, input swap, input load, input [2:0] number,
    input acknowledged, input may_activate, input swap_comes
);

    localparam LANE_WORDS = 4 * LANES;
    localparam SET_WORDS = LANE_WORDS + 16;
    localparam OF_LANE = 1, OF_OFFSET = 2, OF_MEAN = 3;
    localparam IDLE = 0, FETCH = 1, HAND_OVER = 2, WRITTEN = 3, ASK_SWAP = 4, WAIT_FOR_SWAP = 5;

    // The word that the rules follow.
    (* anyconst *) wire [1:0] kind;
    (* anyconst *) wire [7:0] where;
    (* anyconst *) wire [2:0] set;
    wire [7:0] place = kind == OF_LANE ? where : kind == OF_MEAN ? LANE_WORDS + where : LANE_WORDS + 15;
    wire [9:0] stored_at = set * SET_WORDS + place;

    wire access_done, acknowledge_lane, acknowledge_mean, busy, loaded, lane_out, offset_out, mean_out;
    wire [31:0] access_answer, data_out;
    wire [7:0] address_out;
    wire refused, swap_out;

    prepared_sets sets (
        .clock(clock), .reset(reset), .access_read(access_read), .access_write(access_write),
        .access_set(access_set), .access_word(access_word), .access_data(access_data),
        .access_done(access_done), .access_answer(access_answer), .write_lane(write_lane),
        .write_offset(write_offset), .write_mean(write_mean), .write_turn_step(1'b0),
        .write_address(write_address),
        .write_data(write_data), .acknowledge_lane(acknowledge_lane),
        .acknowledge_mean(acknowledge_mean), .swap(swap), .load(load), .number(number),
        .busy(busy), .loaded(loaded), .lane_out(lane_out), .offset_out(offset_out),
        .mean_out(mean_out), .address_out(address_out), .data_out(data_out),
        .acknowledged(acknowledged), .may_activate(may_activate), .refused(refused),
        .swap_out(swap_out), .swap_comes(swap_comes)
    );

    wire [2:0] probe_now;
    wire [6:0] probe_base, probe_ram_place;
    wire [4:0] probe_place;
    wire [2:0] probe_waiting, probe_in_flight;
    wire [31:0] probe_ram_word;
    wire probe_own_write, probe_ram_writes;

    wire [1:0] out = lane_out ? OF_LANE : offset_out ? OF_OFFSET : mean_out ? OF_MEAN : 0;
    wire processor_writes = write_lane || write_offset || write_mean;
    wire acknowledges = acknowledge_lane || acknowledge_mean;

    reg running = 0, load_then = 0, access_under_way = 0, under_way = 0, waits = 0;
    reg [2:0] number_then;
    reg [7:0] address_then;
    reg [31:0] data_then, access_data_then;
    reg [12:0] access_then;
    reg [1:0] asked_kind = 0;
    // `pending`: the write that the bank has received and not yet acknowledged. idle: the word that the rules follow,
    // in the idle bank. stored: this word in the memory of the sets.
    reg [1:0] pending = 0;
    reg [7:0] pending_address;
    reg [31:0] pending_data, idle, stored, stored_then;
    reg read_it = 0;

    wire is_it = pending == kind && (kind == OF_OFFSET || pending_address == where);
    wire out_is_it = out == kind && (kind == OF_OFFSET || address_out == where);
    wire of_this_set = number == set;

    always @(posedge clock) begin
        running <= 1;
        load_then <= load && !reset;
        number_then <= number;
        address_then <= write_address;
        data_then <= write_data;
        access_then <= {access_set, access_word};
        access_data_then <= access_data;
        access_under_way <= !reset && (access_read || access_write || (access_under_way && !access_done));
        under_way <= !reset && (processor_writes || (under_way && !acknowledges));
        if (processor_writes) asked_kind <= write_lane ? OF_LANE : write_offset ? OF_OFFSET : OF_MEAN;
        waits <= !reset && (waits || swap_out) && !swap_comes;
        if (out != 0) begin
            pending <= out;
            pending_address <= address_out;
            pending_data <= data_out;
        end else if (acknowledged) pending <= 0;
        if (acknowledged && is_it) idle <= pending_data;
        if (reset) pending <= 0;
        if (probe_ram_writes && probe_ram_place == stored_at) stored <= access_data;
        stored_then <= stored;
        read_it <= probe_ram_place == stored_at;
    end

    // High if the word that the rules follow has been handed to the idle bank since the load began.
    wire handed = probe_now == HAND_OVER ? place < probe_place : probe_now >= WRITTEN;

    always @* begin
        assume (running || reset);
        assume (set <= HEADS && kind != 0);
        assume (kind != OF_LANE || where < LANE_WORDS);
        assume (kind != OF_MEAN || where <= 8);
        // The memory outputs the word one clock after a read of its address.
        assume (!read_it || probe_ram_word == stored_then);
        // head_failover requests one load at a time, of a set that is built, and does not change the number during the
        // load.
        assume (number <= HEADS);
        assume (!load || (!busy && !load_then));
        assume (!(load_then || busy) || number == number_then);
        // The bus makes one access at a time and keeps address and data until the answer; a swap is an access, too.
        assume (!(access_read || access_write) || !access_under_way);
        assume (!access_under_way || ({access_set, access_word} == access_then
                                      && access_data == access_data_then));
        assume (write_lane + write_offset + write_mean <= 1);
        assume (!processor_writes || !under_way);
        assume (!under_way || (write_address == address_then && write_data == data_then));
        assume (!write_lane || write_address < LANE_WORDS);
        assume (!write_mean || write_address < 16);
        assume (!swap || (!under_way && !processor_writes));
        // The banks acknowledge the write that they have, but not while a swap waits; a swap comes only after its
        // request.
        assume (!acknowledged || (pending != 0 && !waits && !swap_out));
        assume (!swap_comes || waits || swap_out);
        if (running) begin
            whole: assert (!(loaded && of_this_set) || idle == stored);
            allowed: assert (!swap_out || may_activate);
            asked: assert (!swap_out || probe_now == ASK_SWAP || (probe_now == IDLE && swap));
            refusal: assert (refused == ((swap && probe_now == IDLE || probe_now == ASK_SWAP) && !may_activate));
            of_a_set: assert (!loaded || (swap_comes && probe_now >= ASK_SWAP));
            one_write: assert (!(out != 0 && pending != 0));
            no_write: assert (!(swap_out || probe_now == WAIT_FOR_SWAP) || (out == 0 && pending == 0));
            reaches: assert (!acknowledges || (pending == asked_kind && pending_data == write_data
                             && (pending == OF_OFFSET || pending_address == write_address)));

            // Lemmas for the induction.
            assert (probe_now <= WAIT_FOR_SWAP);
            // No turn step is written.
            assert (probe_waiting <= OF_MEAN && probe_in_flight <= OF_MEAN);
            assert (busy == (probe_now != IDLE));
            assert (!busy || probe_base == number * SET_WORDS);
            assert (!busy || probe_place <= LANE_WORDS + 8 || probe_place == LANE_WORDS + 15);
            assert (probe_now != FETCH || probe_place == 0);
            assert (!(probe_now == HAND_OVER && probe_place == 0) || probe_in_flight == 0);
            assert (!(probe_now == HAND_OVER && probe_place != 0) || probe_in_flight != 0);
            assert (probe_now < WRITTEN || probe_place == LANE_WORDS + 15);
            assert (probe_now != WRITTEN || probe_in_flight == OF_OFFSET);
            assert (probe_in_flight == (out != 0 ? out : pending));
            assert (pending == 0 || out != 0 || (pending_address == address_out && pending_data == data_out));
            assert (probe_now < ASK_SWAP || probe_in_flight == 0);
            assert (!((probe_now == HAND_OVER || probe_now == WRITTEN) && probe_in_flight != 0) || probe_own_write);
            assert (!((probe_now == IDLE || probe_now == FETCH) && probe_in_flight != 0) || !probe_own_write);
            assert (under_way == (probe_waiting != 0 || (probe_in_flight != 0 && !probe_own_write)));
            assert (!(probe_waiting != 0 && probe_in_flight != 0) || probe_own_write);
            assert (probe_waiting == 0 || probe_waiting == asked_kind);
            assert (!(probe_in_flight != 0 && !probe_own_write)
                    || (probe_in_flight == asked_kind && data_out == write_data && address_out == write_address));
            assert (probe_now != WAIT_FOR_SWAP || waits);
            assert (!waits || probe_now != WRITTEN && probe_now != ASK_SWAP);
            assert (!(waits && probe_now == HAND_OVER) || probe_place <= 1);
            assert (!(handed && of_this_set)
                    || (out != 0 && out_is_it ? data_out == stored
                        : pending != 0 && is_it ? pending_data == stored : idle == stored));
            assert (!(probe_now == HAND_OVER && of_this_set && probe_place == place && out == 0) || read_it);

            cover (loaded && number == 1);
            cover (refused && probe_now == IDLE);
            cover (swap && probe_now == HAND_OVER);
            cover (acknowledge_mean);
        end
    end

endmodule
