-- SPDX-License-Identifier: Apache-2.0
--
-- # cordic_rotation
--
-- Computes the cosine of an angle of the first quadrant: it rotates a vector in CORDIC_ITERATIONS iterations, by
-- equations (10) to (12) of the paper with corrected signs and a corrected start value (see the errata). It omits the
-- logic that only the sine would need.
--
-- **Latency.** The cosine comes CORDIC_ITERATIONS − 1 = 15 clocks after the angle: one clock per iteration, except
-- iteration 0, which always turns to the left by an eighth of a turn and needs no adder. The entity accepts one angle
-- per clock.
--
-- **Number formats.** place has 22 bits in units of 2⁻²⁴ turn. x is s1.COSINE_WIDTH, with two fraction bits more than
-- the rounded cosine of harmonic_lane. y is s1.(COSINE_WIDTH − 4), because it changes x by at most 2⁻⁷ of its value.
-- z is in units of 2⁻²¹ turn (COSINE_WIDTH + 3 fraction bits, 24 at most); each stage has as many bits as its largest z
-- requires: 19 bits in the first stage, 6 in the last.
--
-- **z** is the angle that is still to be rotated. The bits of the phase below 2⁻²¹ turn are truncated. A value of z
-- stands for the middle of the truncated interval, that is for this value plus half a unit. The half unit is not
-- stored: it needs no logic, and it does not change the sign.
--
-- **Mirrored angles.** Because the half unit is not stored, the complement of an angle has the complement of z in every
-- stage. The adder of iteration 1 also forms this complement: each of its LUTs has a free input for `mirrored`.
--
-- **x and y.** After the iterations 0 to 6, x and y are each one of 64 constants, rounded from exact values. Each later
-- addition or subtraction takes one adder, whose carry input rounds the shifted operand. After iteration 9 y keeps its
-- value: the square of the remaining angle is then below 2⁻¹⁸, so a further rotation of y would change x by less than
-- half a unit.
--
-- **Error.** Exhaustive sweeps, which include the later rounding to s1.16, show errors of the cosine of at most
-- 5.4·10⁻⁵ over all phases of 20 bits and 5.6·10⁻⁵ over all phases of 24 bits. The bounds (A.1) + (A.5) of the paper,
-- as printed, give 1.18·10⁻⁴.
--
-- There is no reset, because no register holds state.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;
  use ieee.math_real.all;

  use work.cordic_pkg.all;
  use work.number_formats_pkg.all;

entity cordic_rotation is
  generic (
    COSINE_WIDTH      : positive range 8 to 24 := work.number_formats_pkg.COSINE_WIDTH;
    CORDIC_ITERATIONS : positive range 8 to 24 := work.number_formats_pkg.CORDIC_ITERATIONS
  );
  port (
    clock    : in    std_ulogic;
    place    : in    u_unsigned(PHASE_WIDTH - 3 downto 0);                                -- 2⁻²⁴ turn
    mirrored : in    std_ulogic;                                                          -- level: the angle is the complement of place
    cosine   : out   u_signed(COSINE_WIDTH + GUARD_WIDTH - 1 downto 0) := (others => '0') -- s1.COSINE_WIDTH
  );
end entity cordic_rotation;

architecture rtl of cordic_rotation is

  constant LAST           : positive := CORDIC_ITERATIONS - 1;
  constant T              : positive := TABULATED_ITERATIONS;
  constant FRACTION       : positive := COSINE_WIDTH - 2 + GUARD_WIDTH;
  constant WIDTH          : positive := COSINE_WIDTH + GUARD_WIDTH;
  constant Y_WIDTH        : positive := WIDTH - Y_SAVED_WIDTH;
  -- The first iteration that does not change y.
  constant Y_FINAL        : positive := (FRACTION + 3) / 2;
  constant Z_FRACTION     : positive := angle_fraction(COSINE_WIDTH);
  constant Z_WIDTH        : positive := Z_FRACTION - 2;
  constant STEPS          : naturals := rotation_steps(CORDIC_ITERATIONS, Z_FRACTION);
  constant WIDTHS         : naturals := remainder_widths(STEPS, Z_FRACTION);

  subtype remainder is u_signed(Z_WIDTH - 1 downto 0);

  type x_coordinates is array (natural range <>) of u_signed(WIDTH - 1 downto 0);

  type y_coordinates is array (natural range <>) of u_signed(Y_WIDTH - 1 downto 0);

  type remainders is array (natural range <>) of remainder;

  subtype direction is u_unsigned(1 to T - 1);

  type directions is array (natural range <>) of direction;

  function rounded (
    table : reals
  ) return x_coordinates is

    variable result : x_coordinates(table'reverse_range);

  begin

    for index in table'range loop
      result(index) := to_signed(integer(round(table(index) * 2.0 ** FRACTION)), WIDTH);
    end loop;

    return result;

  end function rounded;

  function rounded (
    table : reals
  ) return y_coordinates is

    variable result : y_coordinates(table'reverse_range);

  begin

    for index in table'range loop
      result(index) := to_signed(integer(round(table(index) * 2.0 ** (FRACTION - Y_SAVED_WIDTH))), Y_WIDTH);
    end loop;

    return result;

  end function rounded;

  constant X_TABLE : x_coordinates := rounded(tabulated_vectors(start_radius(CORDIC_ITERATIONS), false));
  constant Y_TABLE : y_coordinates := rounded(tabulated_vectors(start_radius(CORDIC_ITERATIONS), true));

begin

  rotate : process (clock) is

    -- Registers; each index is the iteration that reads the register. turned(i)(j) is high if z of iteration j was
    -- negative.
    variable x      : x_coordinates(T to LAST) := (others => (others => '0'));
    variable y      : y_coordinates(T to LAST) := (others => (others => '0'));
    variable z      : remainders(2 to LAST)    := (others => (others => '0'));
    variable turned : directions(2 to T - 1)   := (others => (others => '0'));

    variable left  : std_ulogic;
    variable turn  : direction;
    variable old_z : remainder;
    variable new_x : u_signed(WIDTH - 1 downto 0);

  begin

    if rising_edge(clock) then

      -- The loop begins with the last iteration, so that each variable is read before it takes its new value.
      for i in LAST downto 1 loop
        if i > 1 then
          old_z := z(i);
        else
          -- Iteration 0 subtracts an eighth of a turn.
          old_z              := u_signed(place(place'high downto place'length - Z_WIDTH));
          old_z(Z_WIDTH - 1) := not old_z(Z_WIDTH - 1);
          old_z              := old_z xor (old_z'range => mirrored);
        end if;
        left := not old_z(WIDTHS(i) - 1);

        if i >= T then
          new_x := add_or_subtract(x(i), resize(shift_right(y(i) & '0', i - Y_SAVED_WIDTH), WIDTH + 1), left);

          if i = LAST then
            cosine <= new_x;
          else
            x(i + 1) := new_x;

            if i < Y_FINAL then
              y(i + 1) := add_or_subtract(y(i), resize(shift_right(x(i) & '0', i + Y_SAVED_WIDTH), Y_WIDTH + 1), not left);
            else
              y(i + 1) := y(i);
            end if;
          end if;
        else
          turn := (others => '0');
          if i > 1 then
            turn := turned(i);
          end if;
          turn(i) := not left;

          if i < T - 1 then
            turned(i + 1) := turn;
          else
            x(T) := X_TABLE(to_integer(turn));
            y(T) := Y_TABLE(to_integer(turn));
          end if;
        end if;

        if i < LAST then
          z(i + 1)(WIDTHS(i + 1) - 1 downto 0) := remainder_after(
            old_z(WIDTHS(i + 1) - 1 downto 0),
            u_signed(to_unsigned(STEPS(i), WIDTHS(i + 1))),
            left
          );
        end if;
      end loop;

    end if;

  end process rotate;

end architecture rtl;
