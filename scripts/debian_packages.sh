# shellcheck shell=bash
# Functions for the install scripts: they unpack packages of another Debian release into a folder of
# this tree. They install nothing and do not use the system's packages; apt checks the signatures.
#
# A script that sources this file sets TAG (prefix of the messages), SUITE (the release), TARGET
# (the folder) and LOG (the file of the log). It may set BY_HAND: lines that tell the user what to do
# if a step fails.
#
# DEBIAN_MIRROR=http://…/debian selects a mirror in place of that of the machine's apt sources.
# APT_SOURCES is the folder of apt's sources; tests set this variable.

KEYRING=/usr/share/keyrings/debian-archive-keyring.gpg
APT_SOURCES=${APT_SOURCES:-/etc/apt}
DEFAULT_MIRROR=http://deb.debian.org/debian
BY_HAND=()

say() { printf '[%s] %s\n' "$TAG" "$*" >&2; }

give_up() {
    {
        printf '\n[%s] %s\n\n' "$TAG" "$1"
        shift
        [ $# -eq 0 ] || printf '  %s\n' "$@"
        printf '\n'
    } >&2
    exit 1
}

# Prints the address of the first Debian archive in the machine's own apt sources, which may have
# either of apt's two formats; it leaves out the archive of security updates. With `ubuntu` as $1 it
# prints the address of the first Ubuntu archive.
machine_mirror() {
    {
        sed -n 's/^[[:space:]]*URIs:[[:space:]]*//p' "$APT_SOURCES"/sources.list.d/*.sources 2>/dev/null || true
        sed -nE 's/^[[:space:]]*deb[[:space:]]+(\[[^]]*\][[:space:]]*)?([^[:space:]]+).*/\2/p' \
            "$APT_SOURCES"/sources.list "$APT_SOURCES"/sources.list.d/*.list 2>/dev/null || true
    } | tr ' ' '\n' | sed 's,/*$,,' | grep -E "/${1:-debian}\$" | grep -vE '/(linux|ppa)/[a-z]+$' | head -n 1 || true
}

fetch_failed() {
    tail -n 12 "$LOG" >&2
    give_up "$1 (is there a network? mirror: $mirror)" \
        "Another mirror: DEBIAN_MIRROR=$DEFAULT_MIRROR $0" \
        "The whole log: $LOG" "${BY_HAND[@]}"
}

# Sets architecture, loader and triplet. Ends the script if the machine is not amd64; $1 is the name
# of the program that exists for amd64 only.
need_debian_amd64() {
    for tool in apt-get dpkg-deb dpkg; do
        command -v "$tool" >/dev/null || give_up \
            "$tool is missing: this script unpacks Debian packages and needs Debian's or Ubuntu's tools." \
            "${BY_HAND[@]}"
    done
    architecture=$(dpkg --print-architecture)
    case $architecture in
        amd64) loader=ld-linux-x86-64.so.2 triplet=x86_64-linux-gnu ;;
        *) give_up "There is no $1 for the architecture $architecture, only for amd64." "${BY_HAND[@]}" ;;
    esac
    [ -r "$KEYRING" ] || give_up "The keys of the Debian archive are missing: $KEYRING" \
        "apt-get install debian-archive-keyring, then start again."
}

# Fetches the package lists of $SUITE into the folder $work, which take_into_use moves to $TARGET.
open_archive() {
    mirror=${DEBIAN_MIRROR:-$(machine_mirror)}
    mirror=${mirror:-$DEFAULT_MIRROR}
    work=$TARGET.part
    rm -rf "$work"
    mkdir -p "$work"/{apt/lists/partial,apt/cache/archives/partial,packages,bin} "$(dirname "$LOG")"
    : >"$work/apt/status"
    printf 'deb [signed-by=%s] %s %s main\n' "$KEYRING" "$mirror" "$SUITE" >"$work/apt/sources.list"
    apt_options=(-q
        -o Dir::Etc::SourceList="$work/apt/sources.list" -o Dir::Etc::SourceParts=/dev/null
        -o Dir::Etc::Preferences=/dev/null -o Dir::Etc::PreferencesParts=/dev/null
        -o Dir::State="$work/apt" -o Dir::State::Lists="$work/apt/lists"
        -o Dir::State::Status="$work/apt/status"
        -o Dir::Cache="$work/apt/cache" -o APT::Architecture="$architecture"
        -o APT::Architectures="$architecture" -o Acquire::Languages=none
        -o APT::Install-Recommends=false
        -o APT::Sandbox::User="$(id -un)" -o Debug::NoLocking=1
        -o Acquire::Retries=2 -o Acquire::http::Timeout=30)
    apt-get "${apt_options[@]}" -o APT::Update::Error-Mode=any update >"$LOG" 2>&1 ||
        fetch_failed "The list of packages could not be fetched."
}

# Fetches the named packages without the packages on which they depend.
fetch_packages() {
    (cd "$work/packages" && apt-get "${apt_options[@]}" download "$@") >>"$LOG" 2>&1 ||
        fetch_failed "The packages could not be fetched."
}

# Fetches the named packages and all packages on which these depend.
fetch_with_dependencies() {
    apt-get "${apt_options[@]}" -y --download-only install "$@" >>"$LOG" 2>&1 ||
        fetch_failed "The packages could not be fetched."
    mv "$work"/apt/cache/archives/*.deb "$work/packages"
}

# Unpacks the package file $1. $2 … are tar patterns of the files to unpack; without patterns it
# unpacks all files.
unpack_package() {
    local package=$1
    shift
    dpkg-deb --fsys-tarfile "$package" | tar -x -C "$work" --wildcards "$@" >>"$LOG" 2>&1 ||
        give_up "$(basename "$package") could not be unpacked: is the disk full?" "The log: $LOG"
}

# Writes bin/$1, which starts the program $2 with the libraries of the unpacked packages. $3 … are
# lines that bin/$1 executes before it starts the program.
write_starter() {
    local name=$1 program=$2 ld
    shift 2
    ld=$(cd "$work" && find . -name "$loader" -type f | head -n 1)
    [ -n "$ld" ] && [ -f "$work/$program" ] ||
        give_up "The packages are not made up as expected: $program or $loader is not in them." \
            "Look into $work and mend $0."
    {
        printf '#!/bin/sh\n# Starts the program with the libraries of its packages; made by %s\n' "$(basename "$0")"
        printf 'root=$(CDPATH= cd -- "$(dirname -- "$0")/.." && pwd)\n'
        [ $# -eq 0 ] || printf '%s\n' "$@"
        printf 'exec "$root/%s" --library-path \\\n    ' "$ld"
        printf '"$root/usr/lib/%s:$root/lib/%s:$root/usr/lib" ' "$triplet" "$triplet"
        printf '"$root/%s" "$@"\n' "$program"
    } >"$work/bin/$name"
    chmod +x "$work/bin/$name"
}

# Replaces $TARGET by the folder into which the packages were unpacked.
take_into_use() {
    rm -rf "$work/apt" "$work/packages" "$TARGET"
    mv "$work" "$TARGET"
}
