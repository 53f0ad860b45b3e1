#!/usr/bin/env bash
# Runs this project's commands on complete Linux systems, each of which is installed into its own folder.
#
#   scripts/try_systems.sh [OPTION]... [SYSTEM]... [TARGET]... [VARIABLE=VALUE]...
#
#   SYSTEM    debian12, debian13, ubuntu2404 (without one: all three)
#   TARGET    test or demo: run `make test` or `make demo`; install: run scripts/try_install.sh, that
#             is, `pip install .` in a new environment and a diagnosis without the tree (without one:
#             all three)
#   VARIABLE  passed to make, for example PYTEST_OPTIONS="-k register"
#
#   --folder DIR   folder of the systems, 5 GB each (default: build/systems)
#   --commit REV   commit to test (default: HEAD); uncommitted changes are not tested
#   --fresh        make the systems again, from the packages of the archive
#   --page FILE    write the table of all results to FILE, as a page in Markdown
#
# debootstrap makes each system once, and the script keeps it; the tree in it is a new clone every
# time. DIR/results/SYSTEM.toml states for each system which targets ran, with which versions, and
# how they ended; the logs are in the same folder. Exit code 0: every target passed. 2: a tool is
# missing, or the user is not root. 1: any other failure.
#
# The script needs root, debootstrap and the archives. It runs in its own namespaces, so that its
# mounts and processes end with the script, however it ends.
#
# DEBIAN_MIRROR and UBUNTU_MIRROR select other mirrors than those of the machine's apt sources.
set -euo pipefail

SYSTEMS=(debian12 debian13 ubuntu2404)
TARGETS=(test demo install)
TREE=/srv/arctrue # folder of the clone in each system
NEEDED_TOOLS=(debootstrap unshare mount chroot git apt-config)

usage() { sed -n '2,/^set -/{/^#/s/^# \{0,1\}//p}' "${BASH_SOURCE[0]}"; }

if [ "${TRY_SYSTEMS_INSIDE:-}" != yes ]; then
    for word in "$@"; do
        case $word in -h | --help) usage && exit ;; esac
    done
    missing=()
    for tool in "${NEEDED_TOOLS[@]}"; do
        PATH=$PATH:/usr/sbin:/sbin command -v "$tool" >/dev/null || missing+=("$tool")
    done
    if [ ${#missing[@]} -ne 0 ]; then
        printf '[systems] Missing: %s\n  apt-get install debootstrap util-linux mount git\n' "${missing[*]}" >&2
        exit 2
    fi
    if [ "$(id -u)" -ne 0 ]; then
        printf '[systems] Only root may change into another system: sudo %s\n' "$0 $*" >&2
        exit 2
    fi
    # When the first process of the namespace ends, all others in it and its mounts end too.
    TRY_SYSTEMS_INSIDE=yes unshare --mount --pid --fork --kill-child --propagation private -- \
        "$BASH" "$0" "$@" </dev/null &
    inside=$!
    trap 'kill -KILL "$inside"; exit 130' INT
    trap 'kill -KILL "$inside"; exit 143' TERM HUP
    code=0
    wait "$inside" || code=$?
    exit "$code"
fi

invoked=$PWD
cd "$(dirname "${BASH_SOURCE[0]}")/.."
PATH=$PATH:/usr/sbin:/sbin
TAG=systems LOG=/dev/null
# shellcheck source=scripts/debian_packages.sh
. scripts/debian_packages.sh

folder=build/systems commit=HEAD fresh='' page=''
systems=() targets=() variables=()
while [ $# -gt 0 ]; do
    case $1 in
    --folder | --commit | --page)
        [ $# -ge 2 ] || give_up "$1 needs a value."
        case $1 in
        --folder) folder=$(cd "$invoked" && realpath -m -- "$2") ;;
        --commit) commit=$2 ;;
        --page) page=$(cd "$invoked" && realpath -m -- "$2") ;;
        esac
        shift
        ;;
    --fresh) fresh=yes ;;
    *=*) variables+=("$1") ;;
    *)
        if [[ " ${SYSTEMS[*]} " == *" $1 "* ]]; then
            systems+=("$1")
        elif [[ " ${TARGETS[*]} " == *" $1 "* ]]; then
            targets+=("$1")
        else
            give_up "'$1' is neither a system (${SYSTEMS[*]}) nor a target (${TARGETS[*]})." "$0 --help"
        fi
        ;;
    esac
    shift
done
[ ${#systems[@]} -ne 0 ] || systems=("${SYSTEMS[@]}")
[ ${#targets[@]} -ne 0 ] || targets=("${TARGETS[@]}")
commit=$(git rev-parse --verify --quiet "$commit^{commit}") || give_up "There is no such commit."
[ -z "$(git status --porcelain)" ] || say "changes that are not committed are not tried"
mkdir -p "$folder"
folder=$(realpath "$folder")
results=$folder/results
mkdir -p "$results"
DEBIAN_MIRROR=${DEBIAN_MIRROR:-$(machine_mirror)}
DEBIAN_MIRROR=${DEBIAN_MIRROR:-$DEFAULT_MIRROR}

# Sets variables for the system $1: title, suite, archive, keys, and debootstrap's script ($steps).
describe() {
    components=main
    case $1 in
    debian12) title="Debian 12" suite=bookworm ;;
    debian13) title="Debian 13" suite=trixie ;;
    ubuntu2404) title="Ubuntu 24.04" suite=noble components=main,universe ;;
    esac
    case $1 in
    debian*)
        variable=DEBIAN_MIRROR
        archive=$DEBIAN_MIRROR
        keys=$KEYRING
        # This script is the same for all releases of Debian.
        steps=/usr/share/debootstrap/scripts/sid
        ;;
    ubuntu*)
        variable=UBUNTU_MIRROR
        archive=${UBUNTU_MIRROR:-$(machine_mirror ubuntu)}
        archive=${archive:-http://archive.ubuntu.com/ubuntu}
        keys=$folder/keys/usr/share/keyrings/ubuntu-archive-keyring.gpg
        # This script is the same for all releases of Ubuntu.
        steps=/usr/share/debootstrap/scripts/gutsy
        ;;
    esac
}

# Fetches the keys of Ubuntu's archive, which are in a package of Debian 13.
fetch_ubuntu_keys() {
    [ -r "$keys" ] && return
    local SUITE=trixie TARGET=$folder/keys LOG=$results/keys.log
    need_debian_amd64 "Ubuntu system"
    open_archive
    fetch_packages ubuntu-keyring
    unpack_package "$work"/packages/ubuntu-keyring_*.deb
    take_into_use
}

# Makes the system $1 in $root unless it is already there.
make_system() {
    if [ -n "$fresh" ] || [ ! -e "$root/.complete" ]; then
        if grep -qF " $root/" /proc/self/mountinfo; then
            give_up "Something is mounted below $root: umount it, then start again."
        fi
        case $1 in ubuntu*) fetch_ubuntu_keys ;; esac
        [ -r "$keys" ] || give_up "The keys of the archive are missing: $keys" \
            "apt-get install debian-archive-keyring, then start again."
        say "$title: making the system from $archive ($suite)"
        rm -rf "$root"
        LOG=$results/$1.debootstrap.log
        debootstrap --variant=minbase --keyring="$keys" --components="$components" \
            --include=ca-certificates,git,make,python3,sudo "$suite" "$root" "$archive" "$steps" \
            >"$LOG" 2>&1 || {
            tail -n 5 "$LOG" >&2
            say "$title could not be made from $archive (another mirror: $variable=...); the log: $LOG"
            rm -rf "$root"
            return 1
        }
        local release
        : >"$root/etc/apt/sources.list"
        for release in "$suite" "$suite-updates"; do
            printf 'deb %s %s %s\n' "$archive" "$release" "${components//,/ }" \
                >>"$root/etc/apt/sources.list"
        done
    fi
}

# Mounts what the system needs, and copies this machine's network settings: names, proxies,
# certificates, pip's indexes.
open_system() {
    local file
    mount -t proc proc "$root/proc"
    mount --rbind /dev "$root/dev"
    mountpoint -q "$root/dev/pts" || mount -t devpts devpts "$root/dev/pts"
    mount --rbind /sys "$root/sys"
    cp -L /etc/resolv.conf /etc/hosts "$root/etc/"
    apt-config dump | grep -E '^Acquire::https?::.*[Pp]roxy' >"$root/etc/apt/apt.conf.d/99machine" || true
    for file in /usr/local/share/ca-certificates/*.crt; do
        [ ! -e "$file" ] || cp -L "$file" "$root/usr/local/share/ca-certificates/"
    done
    in_system / update-ca-certificates >/dev/null 2>&1
    [ ! -e /etc/pip.conf ] || cp -L /etc/pip.conf "$root/etc/"
    for file in .config/pip/pip.conf .pip/pip.conf; do
        [ ! -e "$HOME/$file" ] || install -D -m 600 "$HOME/$file" "$root/root/$file"
    done
}

# Runs the command $2 ... in the folder $1 of the system. Of this shell's environment, the command
# gets only the variables of the network.
in_system() {
    local place=$1 name
    local network=()
    shift
    for name in http_proxy https_proxy no_proxy HTTP_PROXY HTTPS_PROXY NO_PROXY \
        PIP_INDEX_URL PIP_EXTRA_INDEX_URL PIP_TRUSTED_HOST DEBIAN_MIRROR; do
        [ -z "${!name:-}" ] || network+=("$name=${!name}")
    done
    # A shell that starts this script in the background disables Ctrl-C, but tests send this signal.
    env --ignore-environment --default-signal HOME=/root LANG=C.UTF-8 TERM=dumb PATH=/usr/sbin:/usr/bin:/sbin:/bin "${network[@]}" \
        "$(command -v chroot)" "$root" sh -c 'cd "$1" && shift && exec "$@"' sh "$place" "$@"
}

clone_tree() {
    rm -rf "${root:?}$TREE"
    git clone --quiet --no-hardlinks --no-checkout . "$root$TREE"
    git -C "$root$TREE" checkout --quiet --detach "$commit"
}

# Prints the first number in the output of a tool's version command in the system.
version_of() {
    in_system "$TREE" "$@" 2>/dev/null | grep -oE '[0-9]+\.[0-9]+(\.[0-9]+)?' | head -n 1 || true
}

# Prints the attribute $1 of the test suite in pytest's report.
reported() {
    grep -oE "<testsuite [^>]*" "$root$TREE/build/reports/junit.xml" 2>/dev/null |
        grep -oE " $1=\"[0-9]+" | grep -oE '[0-9]+$' || printf 0
}

run_target() {
    case $1 in
    install) in_system "$TREE" scripts/try_install.sh ;;
    *) in_system "$TREE" make "$1" "${variables[@]}" ;;
    esac
}

# Runs the target $2 on the system $1; prints the lines for the result file.
try_target() {
    local log=$results/$1.$2.log begun=$SECONDS code=0 tests failed skipped
    rm -f "$root$TREE/build/reports/junit.xml"
    say "$title: $2 (log: $log)"
    run_target "$2" >"$log" 2>&1 || code=$?
    printf '%s.exit = %d\n%s.seconds = %d\n' "$2" "$code" "$2" $((SECONDS - begun))
    [ ${#variables[@]} -eq 0 ] || printf "%s.variables = '%s'\n" "$2" "${variables[*]}"
    if [ "$2" = test ]; then
        tests=$(reported tests) skipped=$(reported skipped)
        failed=$(($(reported failures) + $(reported errors)))
        printf 'test.passed = %d\ntest.failed = %d\ntest.skipped = %d\n' \
            $((tests - failed - skipped)) "$failed" "$skipped"
        grep -aE '^(FAILED|ERROR) ' "$log" >&2 || true
    fi
    if [ "$code" -eq 0 ]; then
        say "$title: $2 passed"
    else
        tail -n 5 "$log" >&2
        say "$title: $2 FAILED (exit code $code)"
    fi
}

# Makes the system $1, runs the targets on it, and writes its result file.
try_system() {
    local root=$folder/$1 file=$results/$1.toml target lines log kept=''
    local title suite components archive variable keys steps
    describe "$1"
    make_system "$1"
    open_system
    clone_tree
    log=$results/$1.setup.log
    say "$title: set-up (log: $log)"
    # If the set-up is interrupted, half-installed packages may remain: the system is then made anew.
    rm -f "$root/.complete"
    if ! in_system "$TREE" make setup >"$log" 2>&1; then
        tail -n 12 "$log" >&2
        say "$title: the set-up FAILED"
        return 1
    fi
    touch "$root/.complete"
    lines=$(
        printf "system = '%s'\ncommit = '%s'\ndate = '%s'\n" "$title" "$commit" "$(date -u +%F)"
        printf "python = '%s'\n" "$(version_of .venv/bin/python --version)"
        printf "ghdl = '%s'\n" "$(version_of ghdl --version)"
        printf "qemu = '%s'\n" "$(version_of qemu-system-arm --version)"
        printf "gcc = '%s'\n" "$(version_of gcc -dumpfullversion)"
        printf "arm_gcc = '%s'\n" "$(version_of arm-none-eabi-gcc -dumpfullversion)"
    )
    # Results of earlier runs of the same commit are kept.
    if grep -qF "'$commit'" "$file" 2>/dev/null; then
        kept=$(grep -E '^(test|demo|install)\.' "$file" || true)
    fi
    for target in "${targets[@]}"; do
        kept=$(
            grep -vE "^$target\." <<<"$kept" || true
            try_target "$1" "$target"
        )
        { printf '%s\n' "$lines" && grep . <<<"$kept"; } >"$file.part"
        mv "$file.part" "$file"
    done
    for target in "${targets[@]}"; do
        grep -qx "$target\.exit = 0" "$file" || return 1
    done
}

# Prints the value of the key $2 in the result file $1.
value() {
    sed -nE "s/^$2 = '?([^']*)'?$/\1/p" "$1"
}

# Prints in words how the target $2 ended, from the result file $1.
ended() {
    local file=$1 target=$2 words minutes
    words=$(value "$file" "$target.exit")
    [ -n "$words" ] || return 0
    minutes=$((($(value "$file" "$target.seconds") + 30) / 60))
    if [ "$words" -eq 0 ]; then words=passed; else words="**failed**"; fi
    if [ "$target" = test ]; then
        words+=": $(value "$file" test.passed) passed, $(value "$file" test.failed) failed"
        words+=", $(value "$file" test.skipped) skipped"
    fi
    printf '%s, %d min' "$words" "$minutes"
    [ -z "$(value "$file" "$target.variables")" ] || printf ' (%s)' "$(value "$file" "$target.variables")"
}

table() {
    local name file
    printf '| System | Python | GHDL | QEMU | gcc, for the Cortex-A9 | `make test` | `make demo` | `pip install .` | Commit, day |\n'
    printf '|---|---|---|---|---|---|---|---|---|\n'
    for name in "${SYSTEMS[@]}"; do
        file=$results/$name.toml
        [ -e "$file" ] || continue
        printf '| %s | %s | %s | %s | %s, %s | %s | %s | %s | %.9s, %s |\n' \
            "$(value "$file" system)" "$(value "$file" python)" "$(value "$file" ghdl)" \
            "$(value "$file" qemu)" "$(value "$file" gcc)" "$(value "$file" arm_gcc)" \
            "$(ended "$file" test)" "$(ended "$file" demo)" "$(ended "$file" install)" \
            "$(value "$file" commit)" "$(value "$file" date)"
    done
}

try_all() {
    local failed=() name code
    for name in "${systems[@]}"; do
        # In `if try_system`, bash would continue after an error in the function.
        set +e
        (set -e && try_system "$name")
        code=$?
        set -e
        [ "$code" -eq 0 ] || failed+=("$name")
    done
    table
    if [ -n "$page" ]; then
        {
            printf '<!-- Made by scripts/try_systems.sh. Do not edit: scripts/try_systems.sh --page FILE -->\n\n'
            printf '# Systems\n\nWhole runs, each on a new system (debootstrap, chroot) with a new clone of the tree:\n'
            printf '`scripts/try_systems.sh`.\n\n'
            table
        } >"$page"
        say "written: $page"
    fi
    if [ ${#failed[@]} -ne 0 ]; then
        say "FAILED on: ${failed[*]}"
        exit 1
    fi
}

# Both commands are in one line, because bash would read the next line from a file that may have
# changed during the hours of a run.
try_all; exit
