#!/usr/bin/env bash
# Unpacks the open place-and-route tools for the XC7Z020.
#
# Debian 14 (Debian's testing release when this was written) has packages of nextpnr with the chip's
# database, and of Project X-Ray's database and bitstream writer. Nothing is installed: the packages
# are unpacked into build/place_and_route, the databases only for this chip. The programs in
# build/place_and_route/bin use the libraries of the same packages. If the tools are already there,
# the script does nothing.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

SUITE=forky
PACKAGES=(nextpnr-himbaechel-xilinx prjxray prjxray-database)
CHIP=xc7z020
FAMILY=zynq7
TARGET=$PWD/build/place_and_route
LOG=$PWD/build/logs/install_place_and_route.log
TAG=place_and_route
# shellcheck source=scripts/debian_packages.sh
. scripts/debian_packages.sh
BY_HAND=("By other means: docs/device.md, 'Open tools', states where each program is searched.")

# Prints the version line of nextpnr; fails if one of the programs or databases is missing.
version() {
    local line
    line=$("$TARGET/bin/nextpnr-himbaechel-xilinx" --version 2>&1) &&
        { "$TARGET/bin/xc7frames2bit" --help 2>&1 || true; } | grep part_file >/dev/null &&
        [ -r "$TARGET/chipdb-$CHIP.bin" ] && [ -d "$TARGET/database/$FAMILY/$CHIP" ] &&
        printf '%s\n' "${line%%$'\n'*}"
}

if found=$(version); then
    say "there already: $found in $TARGET"
    exit 0
fi

need_debian_amd64 "place and route"
say "taking ${PACKAGES[*]} of Debian's release $SUITE: 31 MB, 202 MB unpacked"
open_archive
fetch_with_dependencies "${PACKAGES[@]}"
for package in "$work"/packages/*.deb; do
    case $(basename "$package") in
        nextpnr-himbaechel-xilinx-chipdb_*) unpack_package "$package" "*/chipdb-$CHIP.bin" ;;
        prjxray-database_*) unpack_package "$package" "*/database/$FAMILY" ;;
        lib* | gcc-*-base* | zlib1g_* | nextpnr-* | prjxray_*) unpack_package "$package" ;;
    esac
done
mv "$work/usr/share/nextpnr/himbaechel/xilinx/chipdb-$CHIP.bin" "$work"
mv "$work/usr/share/prjxray/database" "$work"
for program in nextpnr-himbaechel-xilinx xc7frames2bit bitread; do
    write_starter "$program" "usr/bin/$program"
done
take_into_use
found=$(version) || give_up "Everything was unpacked to $TARGET, but a program does not run." \
    "Look at the output of: $TARGET/bin/nextpnr-himbaechel-xilinx --version"
say "ready: $found in $TARGET"
