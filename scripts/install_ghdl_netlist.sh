#!/usr/bin/env bash
# Unpacks GHDL 5 beside the system's GHDL, for netlists only: scripts/install_ghdl_netlist.sh
#
# GHDL 2.0, which Debian 12 has, writes wrong Verilog (a `case` loses its `when others`, GHDL issue
# 2041, mended in 3.0), but simulates faster than GHDL 5. So simulation keeps the system's GHDL, and
# netlists are made with the one that this script takes from Debian 13's packages. Nothing is
# installed: the packages are unpacked into build/ghdl5, and build/ghdl5/bin/ghdl starts GHDL with
# the libraries of the same packages. When it is there already, this does nothing.
#
# DEBIAN_MIRROR=http://…/debian takes another mirror than that of the machine's apt sources.
# APT_SOURCES: where apt's sources are, for tests.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

SUITE=trixie
PACKAGES=(ghdl-mcode ghdl-common libgnat-14 libc6 libgcc-s1 zlib1g)
TARGET=$PWD/build/ghdl5
GHDL=$TARGET/bin/ghdl
KEYRING=/usr/share/keyrings/debian-archive-keyring.gpg
APT_SOURCES=${APT_SOURCES:-/etc/apt}
DEFAULT_MIRROR=http://deb.debian.org/debian
LOG=$PWD/build/logs/install_ghdl_netlist.log

say() { printf '[ghdl5] %s\n' "$*" >&2; }

give_up() {
    {
        printf '\n[ghdl5] %s\n\n' "$1"
        shift
        [ $# -eq 0 ] || printf '  %s\n' "$@"
        printf '\n'
    } >&2
    exit 1
}

# The version line, if the GHDL runs, knows its libraries and can synthesise.
version() {
    [ -x "$GHDL" ] || return 1
    local line folder
    line=$("$GHDL" --version 2>/dev/null | head -n 1) || return 1
    case $line in "GHDL "[3-9].* | "GHDL "[1-9][0-9].*) ;; *) return 1 ;; esac
    folder=$(mktemp -d)
    # `when others` is what GHDL 2.0 drops.
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

# The first Debian archive in the machine's own sources: of both kinds of files, without security.
machine_mirror() {
    {
        sed -n 's/^[[:space:]]*URIs:[[:space:]]*//p' "$APT_SOURCES"/sources.list.d/*.sources 2>/dev/null || true
        sed -nE 's/^[[:space:]]*deb[[:space:]]+(\[[^]]*\][[:space:]]*)?([^[:space:]]+).*/\2/p' \
            "$APT_SOURCES"/sources.list "$APT_SOURCES"/sources.list.d/*.list 2>/dev/null || true
    } | tr ' ' '\n' | sed 's,/*$,,' | grep -E '/debian$' | head -n 1 || true
}

if found=$(version); then
    say "there already: $found in $TARGET"
    exit 0
fi

for tool in apt-get dpkg-deb dpkg; do
    command -v "$tool" >/dev/null || give_up \
        "$tool is missing: this script unpacks Debian packages and needs Debian's or Ubuntu's tools." \
        "On another system install GHDL 3.0 or newer and Yosys by its own means."
done
architecture=$(dpkg --print-architecture)
case $architecture in
    amd64) loader=ld-linux-x86-64.so.2 triplet=x86_64-linux-gnu ;;
    *) give_up "There is no mcode GHDL for the architecture $architecture, only for amd64." \
        "Install GHDL 3.0 or newer by the system's own means (Debian 13: apt-get install ghdl-llvm)." ;;
esac
[ -r "$KEYRING" ] || give_up "The keys of the Debian archive are missing: $KEYRING" \
    "apt-get install debian-archive-keyring, then start again."

mirror=${DEBIAN_MIRROR:-$(machine_mirror)}
mirror=${mirror:-$DEFAULT_MIRROR}
work=$TARGET.part
rm -rf "$work"
mkdir -p "$work"/{apt/lists/partial,apt/cache/archives/partial,packages,bin} "$(dirname "$LOG")"
: >"$work/apt/status"
printf 'deb [signed-by=%s] %s %s main\n' "$KEYRING" "$mirror" "$SUITE" >"$work/apt/sources.list"
options=(-q
    -o Dir::Etc::SourceList="$work/apt/sources.list" -o Dir::Etc::SourceParts=/dev/null
    -o Dir::Etc::Preferences=/dev/null -o Dir::Etc::PreferencesParts=/dev/null
    -o Dir::State="$work/apt" -o Dir::State::Lists="$work/apt/lists"
    -o Dir::State::Status="$work/apt/status"
    -o Dir::Cache="$work/apt/cache" -o APT::Architecture="$architecture"
    -o APT::Architectures="$architecture" -o Acquire::Languages=none
    -o APT::Sandbox::User="$(id -un)" -o Debug::NoLocking=1
    -o Acquire::Retries=2 -o Acquire::http::Timeout=30)

fetch_failed() {
    tail -n 12 "$LOG" >&2
    give_up "$1 (is there a network? mirror: $mirror)" \
        "Another mirror: DEBIAN_MIRROR=http://deb.debian.org/debian scripts/install_ghdl_netlist.sh" \
        "The whole log: $LOG" \
        "By hand: unpack the Debian 13 packages ${PACKAGES[*]}" \
        "with dpkg-deb -x into one folder, and start its usr/bin/ghdl-mcode through its own loader."
}

say "taking ${PACKAGES[*]} of Debian 13 from $mirror"
apt-get "${options[@]}" -o APT::Update::Error-Mode=any update >"$LOG" 2>&1 ||
    fetch_failed "The list of packages could not be fetched."
(cd "$work/packages" && apt-get "${options[@]}" download "${PACKAGES[@]}") >>"$LOG" 2>&1 ||
    fetch_failed "The packages could not be fetched."
for package in "$work"/packages/*.deb; do
    dpkg-deb -x "$package" "$work" >>"$LOG" 2>&1 ||
        give_up "$(basename "$package") could not be unpacked: is the disk full?" "The log: $LOG"
done

ghdl=$(cd "$work" && find usr/bin -name 'ghdl-mcode*' -type f | head -n 1)
ld=$(cd "$work" && find . -name "$loader" -type f | head -n 1)
prefix=usr/lib/ghdl/mcode/vhdl
[ -n "$ghdl" ] && [ -n "$ld" ] && [ -d "$work/$prefix" ] ||
    give_up "The packages are not made up as expected: GHDL, its libraries or $loader is not in them." \
        "Look into $work and mend this script."
cat >"$work/bin/ghdl" <<WRAPPER
#!/bin/sh
# GHDL with the libraries it came with; made by scripts/install_ghdl_netlist.sh
root=\$(CDPATH= cd -- "\$(dirname -- "\$0")/.." && pwd)
GHDL_PREFIX=\$root/$prefix
export GHDL_PREFIX
exec "\$root/$ld" --library-path \\
    "\$root/usr/lib/$triplet:\$root/lib/$triplet:\$root/usr/lib" "\$root/$ghdl" "\$@"
WRAPPER
chmod +x "$work/bin/ghdl"
rm -rf "$work/apt" "$work/packages" "$TARGET"
mv "$work" "$TARGET"
found=$(version) || give_up "GHDL was unpacked to $TARGET, but does not run or cannot synthesise." \
    "See what it says: $GHDL --version"
say "ready: $found in $TARGET"
