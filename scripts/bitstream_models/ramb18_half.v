// SPDX-License-Identifier: Apache-2.0
//
// Models half of a block RAM, 18 Kbit with two ports, after the 7 Series Memory Resources User Guide (UG473); a
// RAMB36E1 consists of two such halves. A width of 36 selects the simple dual port: port A reads and port B writes; the
// lower half of the data is at the data pins of port A, the upper half at those of port B. The model's pins are the
// signals after the pins' inverters. If both ports use a word in the same clock, a read returns the content before that
// clock.

module ramb18_half #(
    parameter integer READ_WIDTH_A = 18,
    parameter integer READ_WIDTH_B = 18,
    parameter integer WRITE_WIDTH_A = 18,
    parameter integer WRITE_WIDTH_B = 18,
    parameter integer WRITE_MODE_A = 0,  // 0 write first, 1 read first, 2 no change
    parameter integer WRITE_MODE_B = 0,
    parameter integer DOA_REG = 0,
    parameter integer DOB_REG = 0,
    parameter [17:0] INIT_A = 0,
    parameter [17:0] INIT_B = 0,
    parameter [17:0] SRVAL_A = 0,
    parameter [17:0] SRVAL_B = 0,
    parameter [16383:0] INIT = 0,
    parameter [2047:0] INITP = 0
) (
    input  wire        CLKA, CLKB,
    input  wire        ENA, ENB, RSTRAMA, RSTRAMB, RSTREGA, RSTREGB, REGCEA, REGCEB,
    input  wire [13:0] ADDRA, ADDRB,
    input  wire [17:0] DIA, DIB,  // two bits of parity, 16 of data
    input  wire [1:0]  WEA,
    input  wire [3:0]  WEB,
    output wire [17:0] DOA, DOB
);

  localparam IS_WIDE_READ = READ_WIDTH_A == 36;
  localparam IS_WIDE_WRITE = WRITE_WIDTH_B == 36;

  reg [15:0] data[0:1023];
  reg [1:0] parity[0:1023];
  integer place;
  initial
    for (place = 0; place < 1024; place = place + 1) begin
      data[place] = INIT[place*16+:16];
      parity[place] = INITP[place*2+:2];
    end

  // Returns the part of a word that a port of this width reads; `low` is the lower part of its address.
  function [17:0] taken(input integer width, input [17:0] word, input [3:0] low);
    case (width)
      1: taken = {17'd0, word[low]};
      2: taken = {16'd0, word[{low[3:1], 1'b0}+:2]};
      4: taken = {14'd0, word[{low[3:2], 2'b00}+:4]};
      9: taken = {1'b0, low[3] ? word[17] : word[16], 8'd0, low[3] ? word[15:8] : word[7:0]};
      default: taken = word;
    endcase
  endfunction

  // Returns the word after a write by a port of this width.
  function [17:0] put(input integer width, input [17:0] word, input [3:0] low, input [17:0] value,
                      input [1:0] enable);
    reg [17:0] changed;
    begin
      changed = word;
      case (width)
        1: if (enable[low[3]]) changed[low] = value[0];
        2: if (enable[low[3]]) changed[{low[3:1], 1'b0}+:2] = value[1:0];
        4: if (enable[low[3]]) changed[{low[3:2], 2'b00}+:4] = value[3:0];
        9:
        if (enable[low[3]]) begin
          changed[{low[3], 3'b000}+:8] = value[7:0];
          changed[16+low[3]] = value[16];
        end
        default: begin
          if (enable[0]) {changed[16], changed[7:0]} = {value[16], value[7:0]};
          if (enable[1]) {changed[17], changed[15:8]} = {value[17], value[15:8]};
        end
      endcase
      put = changed;
    end
  endfunction

  reg [17:0] out_a = INIT_A, out_b = INIT_B, kept_a = INIT_A, kept_b = INIT_B;
  wire [9:0] word_a = ADDRA[13:4], word_b = ADDRB[13:4];
  wire [17:0] old_a = {parity[word_a], data[word_a]};
  wire [17:0] old_b = {parity[word_b], data[word_b]};
  wire [17:0] new_a = put(WRITE_WIDTH_A, old_a, ADDRA[3:0], DIA, WEA);
  wire [17:0] new_b = put(WRITE_WIDTH_B, old_b, ADDRB[3:0], DIB, WEB[1:0]);
  wire writes_a = ENA && |WEA && !IS_WIDE_READ && !IS_WIDE_WRITE;
  wire writes_b = ENB && |WEB;

  // The simple dual port reads or writes two words at once.
  wire [9:0] low_word = {ADDRB[13:5], 1'b0}, high_word = {ADDRB[13:5], 1'b1};
  wire [17:0] old_low = {parity[low_word], data[low_word]};
  wire [17:0] old_high = {parity[high_word], data[high_word]};
  wire [17:0] new_low = put(18, old_low, 4'd0, DIA, WEB[1:0]);
  wire [17:0] new_high = put(18, old_high, 4'd0, DIB, WEB[3:2]);

  always @(posedge CLKA) begin
    if (writes_a) {parity[word_a], data[word_a]} <= new_a;
    if (ENA) begin
      if (RSTRAMA) out_a <= SRVAL_A;
      else if (IS_WIDE_READ) begin
        out_a <= {parity[{ADDRA[13:5], 1'b0}], data[{ADDRA[13:5], 1'b0}]};
      end else if (!(writes_a && WRITE_MODE_A == 2)) begin
        out_a <= taken(READ_WIDTH_A, (writes_a && WRITE_MODE_A == 0) ? new_a : old_a, ADDRA[3:0]);
      end
    end
    if (RSTREGA) kept_a <= SRVAL_A;
    else if (REGCEA) kept_a <= out_a;
  end

  generate
    if (IS_WIDE_READ) begin : wide_read
      always @(posedge CLKA) begin
        if (ENA) begin
          if (RSTRAMA) out_b <= SRVAL_B;
          else out_b <= {parity[{ADDRA[13:5], 1'b1}], data[{ADDRA[13:5], 1'b1}]};
        end
        if (RSTREGA) kept_b <= SRVAL_B;
        else if (REGCEA) kept_b <= out_b;
      end
    end else begin : narrow_read
      always @(posedge CLKB) begin
        if (ENB) begin
          if (RSTRAMB) out_b <= SRVAL_B;
          else if (!(writes_b && WRITE_MODE_B == 2)) begin
            out_b <= taken(READ_WIDTH_B, (writes_b && WRITE_MODE_B == 0) ? new_b : old_b, ADDRB[3:0]);
          end
        end
        if (RSTREGB) kept_b <= SRVAL_B;
        else if (REGCEB) kept_b <= out_b;
      end
    end
    if (IS_WIDE_WRITE) begin : wide_write
      always @(posedge CLKB)
        if (writes_b) begin
          {parity[low_word], data[low_word]} <= new_low;
          {parity[high_word], data[high_word]} <= new_high;
        end
    end else begin : narrow_write
      always @(posedge CLKB) if (writes_b) {parity[word_b], data[word_b]} <= new_b;
    end
  endgenerate

  assign DOA = DOA_REG ? kept_a : out_a;
  assign DOB = DOB_REG ? kept_b : out_b;

endmodule
