#!/usr/bin/env bash
# Unpacks GHDL 5, which makes netlists, in addition to the system's GHDL.
#
# GHDL 2.0 of Debian 12 writes wrong Verilog (a `case` loses its `when others`, GHDL issue 2041).
# GHDL 4.1 of Ubuntu 24.04 writes wrong Verilog too (it shifts signed numbers to the right without
# sign extension, issue 2750). But GHDL 2.0 simulates faster than GHDL 5. Therefore the system's GHDL
# simulates, and the GHDL that this script takes from Debian 13's packages makes netlists. Nothing is
# installed: the packages are unpacked into build/ghdl5, and build/ghdl5/bin/ghdl starts GHDL with
# the libraries of the same packages. If this GHDL is already there, the script does nothing.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

SUITE=trixie
PACKAGES=(ghdl-mcode ghdl-common libgnat-14 libc6 libgcc-s1 zlib1g)
TARGET=$PWD/build/ghdl5
GHDL=$TARGET/bin/ghdl
LOG=$PWD/build/logs/install_ghdl_netlist.log
TAG=ghdl5
# shellcheck source=scripts/debian_packages.sh
. scripts/debian_packages.sh
BY_HAND=(
    "By other means: GHDL 5.0 or newer (Debian 13: apt-get install ghdl-llvm), named by GHDL_NETLIST,"
    "or the Debian 13 packages ${PACKAGES[*]}"
    "unpacked with dpkg-deb -x into one folder, and its usr/bin/ghdl-mcode through its own loader.")

# Prints GHDL's version line; fails if GHDL does not run, does not find its libraries or cannot
# synthesise.
version() {
    [ -x "$GHDL" ] || return 1
    local line folder
    # The output does not go through head: a program that writes after head has ended may fail.
    line=$("$GHDL" --version 2>/dev/null) || return 1
    line=${line%%$'\n'*}
    case $line in "GHDL "[5-9].* | "GHDL "[1-9][0-9].*) ;; *) return 1 ;; esac
    folder=$(mktemp -d)
    # The probe contains a `when others`, which GHDL 2.0 loses.
    cat >"$folder/probe.vhd" <<'VHDL'
library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

entity probe is
  port (a : in u_unsigned(1 downto 0); b : out u_unsigned(1 downto 0));
end entity probe;

architecture rtl of probe is
begin
  process (all) is
  begin
    case a is
      when "00"   => b <= "10";
      when others => b <= a;
    end case;
  end process;
end architecture rtl;
VHDL
    if "$GHDL" --synth --std=08 --workdir="$folder" --out=verilog "$folder/probe.vhd" -e probe \
        >"$folder/probe.v" 2>"$folder/log" && grep -q '^module probe' "$folder/probe.v"; then
        rm -rf "$folder"
        printf '%s\n' "$line"
    else
        cat "$folder/log" >&2
        rm -rf "$folder"
        return 1
    fi
}

if found=$(version); then
    say "there already: $found in $TARGET"
    exit 0
fi

need_debian_amd64 "mcode GHDL"
say "taking ${PACKAGES[*]} of Debian 13"
open_archive
fetch_packages "${PACKAGES[@]}"
for package in "$work"/packages/*.deb; do
    unpack_package "$package"
done

ghdl=$(cd "$work" && find usr/bin -name 'ghdl-mcode*' -type f | head -n 1)
prefix=usr/lib/ghdl/mcode/vhdl
[ -n "$ghdl" ] && [ -d "$work/$prefix" ] || give_up \
    "The packages are not made up as expected: GHDL or its libraries are not in them." \
    "Look into $work and mend this script."
write_starter ghdl "$ghdl" "GHDL_PREFIX=\$root/$prefix" "export GHDL_PREFIX"
take_into_use
found=$(version) || give_up "GHDL was unpacked to $TARGET, but does not run or cannot synthesise." \
    "Look at the output of: $GHDL --version"
say "ready: $found in $TARGET"
