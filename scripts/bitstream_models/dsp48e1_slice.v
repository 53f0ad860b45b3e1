// SPDX-License-Identifier: Apache-2.0
//
// Models a DSP48E1 after the 7 Series DSP48E1 Slice User Guide (UG479): input registers, multiplier, X, Y and Z
// multiplexers (tables 2-7 to 2-9), three-input adder and logic unit (tables 2-10, 2-13). The model does not contain
// the pre-adder's port D, SIMD and pattern detection, which the decoder refuses. Its pins are the signals after the
// pins' inverters. A reset has precedence over a clock enable.

module dsp48e1_slice #(
    parameter integer AREG = 1,
    parameter integer BREG = 1,
    parameter integer CREG = 1,
    parameter integer MREG = 1,
    parameter integer PREG = 1,
    parameter integer OPMODEREG = 1,
    parameter integer ALUMODEREG = 1,
    parameter integer INMODEREG = 1,
    parameter integer CARRYINREG = 1,
    parameter integer CARRYINSELREG = 1
) (
    input  wire        CLK,
    input  wire [29:0] A,
    input  wire [17:0] B,
    input  wire [47:0] C,
    input  wire [47:0] PCIN,
    input  wire        CARRYIN,
    input  wire [2:0]  CARRYINSEL,
    input  wire [4:0]  INMODE,
    input  wire [6:0]  OPMODE,
    input  wire [3:0]  ALUMODE,
    input  wire        CEA1, CEA2, CEB1, CEB2, CEC, CEM, CEP, CECTRL, CEALUMODE, CEINMODE, CECARRYIN,
    input  wire        RSTA, RSTB, RSTC, RSTM, RSTP, RSTCTRL, RSTALUMODE, RSTINMODE, RSTALLCARRYIN,
    output wire [47:0] P
);

  reg [29:0] a1 = 0, a2 = 0;
  reg [17:0] b1 = 0, b2 = 0;
  reg [47:0] c1 = 0, p1 = 0;
  reg [42:0] m1 = 0;
  reg [4:0] inmode1 = 0;
  reg [6:0] opmode1 = 0;
  reg [3:0] alumode1 = 0;
  reg [2:0] carryinsel1 = 0;
  reg carryin1 = 0;

  always @(posedge CLK) begin
    if (RSTA) begin
      a1 <= 0;
      a2 <= 0;
    end else begin
      if (CEA1) a1 <= A;
      if (CEA2) a2 <= (AREG == 2) ? a1 : A;
    end
    if (RSTB) begin
      b1 <= 0;
      b2 <= 0;
    end else begin
      if (CEB1) b1 <= B;
      if (CEB2) b2 <= (BREG == 2) ? b1 : B;
    end
    if (RSTC) c1 <= 0;
    else if (CEC) c1 <= C;
    if (RSTINMODE) inmode1 <= 0;
    else if (CEINMODE) inmode1 <= INMODE;
    if (RSTCTRL) opmode1 <= 0;
    else if (CECTRL) opmode1 <= OPMODE;
    if (RSTCTRL) carryinsel1 <= 0;
    else if (CECTRL) carryinsel1 <= CARRYINSEL;
    if (RSTALUMODE) alumode1 <= 0;
    else if (CEALUMODE) alumode1 <= ALUMODE;
    if (RSTALLCARRYIN) carryin1 <= 0;
    else if (CECARRYIN) carryin1 <= CARRYIN;
  end

  wire [4:0] inmode = INMODEREG ? inmode1 : INMODE;
  wire [6:0] opmode = OPMODEREG ? opmode1 : OPMODE;
  wire [3:0] alumode = ALUMODEREG ? alumode1 : ALUMODE;
  wire [2:0] carryinsel = CARRYINSELREG ? carryinsel1 : CARRYINSEL;
  wire [29:0] a = (AREG == 0) ? A : a2;
  wire [17:0] b = (BREG == 0) ? B : b2;
  wire [47:0] c = CREG ? c1 : C;

  // INMODE bits 0 and 4 select the first registers of A and B; INMODE bit 1 replaces A by 0 at the multiplier.
  wire [29:0] a_chosen = (inmode[0] && AREG != 0) ? a1 : a;
  wire [24:0] factor_a = inmode[1] ? 25'd0 : a_chosen[24:0];
  wire [17:0] factor_b = (inmode[4] && BREG != 0) ? b1 : b;
  wire signed [42:0] product = $signed(factor_a) * $signed(factor_b);

  always @(posedge CLK) begin
    if (RSTM) m1 <= 0;
    else if (CEM) m1 <= product;
  end
  wire [42:0] m = MREG ? m1 : product;
  wire [47:0] m_extended = {{5{m[42]}}, m};

  reg [47:0] x, y, z;
  always @* begin
    case (opmode[1:0])
      2'b00: x = 48'd0;
      2'b01: x = m_extended;
      2'b10: x = p1;
      default: x = {a, b};
    endcase
    // In the chip, X and Y carry the multiplier's two partial products; here X carries their sum and Y is 0.
    case (opmode[3:2])
      2'b00, 2'b01: y = 48'd0;
      2'b10: y = {48{1'b1}};
      default: y = c;
    endcase
    case (opmode[6:4])
      3'b001: z = PCIN;
      3'b010, 3'b100: z = p1;
      3'b011: z = c;
      3'b101: z = {{17{PCIN[47]}}, PCIN[47:17]};
      3'b110: z = {{17{p1[47]}}, p1[47:17]};
      default: z = 48'd0;
    endcase
  end

  wire carry = (carryinsel == 3'b000) && (CARRYINREG ? carryin1 : CARRYIN);
  wire [47:0] others = x + y + {47'd0, carry};
  wire inverts_z = opmode[3];
  reg [47:0] result;
  always @* begin
    case (alumode)
      4'b0000: result = z + others;
      4'b0001: result = ~z + others;
      4'b0010: result = ~(z + others);
      4'b0011: result = z - others;
      4'b0100, 4'b0111: result = inverts_z ? ~(x ^ z) : x ^ z;
      4'b0101, 4'b0110: result = inverts_z ? x ^ z : ~(x ^ z);
      4'b1100: result = inverts_z ? x | z : x & z;
      4'b1101: result = inverts_z ? x | ~z : x & ~z;
      4'b1110: result = inverts_z ? ~(x | z) : ~(x & z);
      4'b1111: result = inverts_z ? ~x & z : ~x | z;
      default: result = 48'd0;
    endcase
  end

  always @(posedge CLK) begin
    if (RSTP) p1 <= 0;
    else if (CEP) p1 <= result;
  end
  assign P = PREG ? p1 : result;

endmodule
