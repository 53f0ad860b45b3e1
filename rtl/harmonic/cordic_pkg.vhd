-- SPDX-License-Identifier: Apache-2.0
--
-- Computes the constants of the CORDIC rotation of equations (10) and (11) at elaboration, for any number of iterations
-- and bits, and declares the adder of the rotation.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;
  use ieee.math_real.all;

  use work.number_formats_pkg.all;

package cordic_pkg is

  type naturals is array (natural range <>) of natural;

  type reals is array (natural range <>) of real;

  -- Returns the number of fraction bits of z, which is in turns: 21 for a cosine of 18 bits, so that the unit is 2**-21
  -- turn.
  function angle_fraction (
    cosine_width : positive
  ) return positive;

  -- Returns arctan(2**-i) for i = 0 to iterations - 1, in 2**-fraction turn.
  function rotation_steps (
    iterations, fraction : positive
  ) return naturals;

  -- Returns the number of bits of z, sign included, before iteration i = 1 to iterations.
  function remainder_widths (
    steps    : naturals;
    fraction : positive
  ) return naturals;

  -- Returns 1 / (gain of all iterations), the start value x0 of equation (11).
  function start_radius (
    iterations : positive
  ) return real;

  -- Returns one coordinate, y if `of_y` is true and x otherwise, of the vector after the tabulated iterations, for all
  -- directions of the iterations. The vector starts at x = radius, y = 0. Iteration 0 always turns to the left; bit
  -- TABULATED_ITERATIONS - 1 - i of the table's index is high if iteration i turns to the right.
  function tabulated_vectors (
    radius : real;
    of_y   : boolean
  ) return reals;

  -- Returns a + b, or a - b if `subtract` is high, rounded to the last bit of a, with one carry chain. b has one
  -- fraction bit more than a.
  function add_or_subtract (
    a, b     : u_signed;
    subtract : std_ulogic
  ) return u_signed;

  -- Returns angle - step if `left`, otherwise angle + step, on one carry chain.
  function remainder_after (
    angle, step : u_signed;
    left        : std_ulogic
  ) return u_signed;

end package cordic_pkg;

package body cordic_pkg is

  function angle_fraction (
    cosine_width : positive
  ) return positive is
  begin

    -- A phase has 24 bits.
    return minimum(cosine_width + 3, 24);

  end function angle_fraction;

  function rotation_steps (
    iterations, fraction : positive
  ) return naturals is

    variable steps : naturals(0 to iterations - 1);

  begin

    for i in steps'range loop
      steps(i) := natural(round(arctan(2.0 ** (-i)) / MATH_2_PI * 2.0 ** fraction));
    end loop;

    return steps;

  end function rotation_steps;

  function remainder_widths (
    steps    : naturals;
    fraction : positive
  ) return naturals is

    -- z lies within -bound <= z < bound. After iteration 0 the bound is an eighth of a turn.
    variable bound  : natural := 2 ** (fraction - 3);
    variable widths : naturals(1 to steps'length);

  begin

    for i in widths'range loop
      widths(i) := 1;
      while 2 ** (widths(i) - 1) < bound loop
        widths(i) := widths(i) + 1;
      end loop;
      if i < steps'length then
        bound := maximum(steps(i), bound - steps(i));
      end if;
    end loop;

    return widths;

  end function remainder_widths;

  function start_radius (
    iterations : positive
  ) return real is

    variable gain : real := 1.0;

  begin

    for i in 0 to iterations - 1 loop
      gain := gain * sqrt(1.0 + 2.0 ** (-2 * i));
    end loop;

    return 1.0 / gain;

  end function start_radius;

  function tabulated_vectors (
    radius : real;
    of_y   : boolean
  ) return reals is

    variable table     : reals(0 to 2 ** (TABULATED_ITERATIONS - 1) - 1);
    variable x         : real;
    variable y         : real;
    variable x_before  : real;
    variable direction : real;

  begin

    for index in table'range loop
      x := radius;
      y := radius;
      for i in 1 to TABULATED_ITERATIONS - 1 loop
        direction := 1.0;
        if (index / 2 ** (TABULATED_ITERATIONS - 1 - i)) mod 2 = 1 then
          direction := -1.0;
        end if;
        x_before := x;
        x        := x - direction * y * 2.0 ** (-i);
        y        := y + direction * x_before * 2.0 ** (-i);
      end loop;
      if of_y then
        table(index) := y;
      else
        table(index) := x;
      end if;
    end loop;

    return table;

  end function tabulated_vectors;

  function add_or_subtract (
    a, b     : u_signed;
    subtract : std_ulogic
  ) return u_signed is

    variable difference : u_signed(a'length downto 0);

  begin

    -- The appended lowest bit generates the carry. If b is subtracted, b's fraction bit there causes a borrow. If b is
    -- added, all bits of b are complemented before the subtraction; the complement of the fraction bit then completes
    -- the two's complement and rounds b. The sum is written as a difference, because Yosys may swap the operands of a
    -- sum: so the operand that enters the carry chain without a LUT is always a.
    difference := (a & '0') - (b xor (b'range => not subtract));
    return difference(a'length downto 1);

  end function add_or_subtract;

  function remainder_after (
    angle, step : u_signed;
    left        : std_ulogic
  ) return u_signed is

    variable difference : u_signed(angle'length downto 0);

  begin

    -- -angle equals (not angle) + 1. So this is step + angle, or (not step) + angle + 1; the appended lowest bit
    -- provides the 1. The constant step enters the carry chain without a LUT, which leaves the LUTs for a function of
    -- the angle.
    difference := ((step & '0') xor (difference'range => left)) - ((not angle) & '1');
    return difference(angle'length downto 1);

  end function remainder_after;

end package body cordic_pkg;
