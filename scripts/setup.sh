#!/usr/bin/env bash
# Installs everything that the Makefile's targets need, and changes nothing else on the machine:
#   1. missing system packages (PACKAGES), among them GHDL, Verilator, Yosys, gcc for the host and the
#      Cortex-A9, QEMU, and the keys of Debian's archive, which step 3 needs; on a system other than
#      Debian 12, Debian 13 and Ubuntu 24.04 the script only names what is missing;
#   2. the Python environment .venv, with exactly the packages of requirements.lock (with hashes) and
#      with this package in editable mode;
#   3. a GHDL for netlists in build/ghdl5, if the system's GHDL is too old;
#   4. a link to LLVM's library in build/llvm_names, with the name that Ubuntu's GHDL loads.
# The script may run any number of times: if nothing is missing, it prints nothing and ends at once.
#
# PYTHON=/usr/bin/python3.12 scripts/setup.sh uses another Python. It must be 3.11 or newer and have
# a shared libpython, because GHDL loads this library; Pythons from pyenv or conda have none.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

PYTHON=${PYTHON:-/usr/bin/python3}
OS_RELEASE=${OS_RELEASE:-/etc/os-release}
PACKAGES=(debian-archive-keyring g++ gcc gcc-arm-none-eabi gdb-multiarch ghdl-llvm ghdl-mcode
    libnewlib-arm-none-eabi make python3-dev python3-venv openocd qemu-system-arm tcl verilator yosys z3
    zlib1g-dev)
LOG=build/logs/setup.log
GHDL_LLVM=${GHDL_LLVM:-/usr/lib/ghdl/llvm/ghdl1-llvm}
LLVM_NAMES=build/llvm_names # tb/support/simulation.py uses this folder too

say() { printf '[setup] %s\n' "$*" >&2; }

give_up() {
    {
        printf '\n[setup] %s\n\n' "$1"
        shift
        printf '  %s\n' "$@"
        printf '\n'
    } >&2
    exit 1
}

log_tail() {
    say "the last lines of $LOG:"
    tail -n 12 "$LOG" >&2
}

system_name() (
    ID=unknown VERSION_ID=
    # shellcheck disable=SC1090
    [ -r "$OS_RELEASE" ] && . "$OS_RELEASE"
    printf '%s' "$ID${VERSION_ID:+ $VERSION_ID}"
)

is_installed() {
    [ "$(dpkg-query -W -f='${db:Status-Status}' "$1" 2>/dev/null)" = installed ]
}

install_packages() {
    local missing=() as_root=() package
    for package in "${PACKAGES[@]}"; do
        is_installed "$package" || missing+=("$package")
    done
    [ ${#missing[@]} -eq 0 ] && return
    local by_hand=("apt-get update && apt-get install --no-install-recommends ${missing[*]}")
    if [ "$(id -u)" -ne 0 ]; then
        if command -v sudo >/dev/null && { [ -t 0 ] || sudo -n true 2>/dev/null; }; then
            as_root=(sudo)
        else
            give_up "System packages are missing, and there is neither root nor sudo to install them." \
                "Ask an administrator to run, then start again:" "" "${by_hand[@]}"
        fi
    fi
    say "installing system packages: ${missing[*]}"
    mkdir -p "$(dirname "$LOG")"
    local apt=("${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -y -q
        -o Acquire::Retries=2 -o Acquire::http::Timeout=30 -o DPkg::Lock::Timeout=300)
    # A broken apt source of another program makes `update` fail although the needed archive is
    # fine. Only the result of the installation counts.
    "${apt[@]}" update >"$LOG" 2>&1 || true
    if ! "${apt[@]}" install --no-install-recommends "${missing[@]}" >>"$LOG" 2>&1; then
        log_tail
        give_up "The system packages could not be installed (is there a network?)." \
            "Run by hand and see what is in the way, then start again" \
            "(on Ubuntu the component 'universe' must be enabled):" "" "${by_hand[@]}"
    fi
}

has_ghdl() {
    local version
    version=$(GHDL_BACKEND=$1 ghdl --version 2>/dev/null) && grep -qi "$1.* code generator" <<<"$version"
}

# Checks the tools on a system whose packages this script does not know.
check_tools() {
    local missing=()
    command -v gcc >/dev/null || missing+=("gcc, and the development files of zlib")
    command -v g++ >/dev/null && command -v verilator >/dev/null ||
        missing+=("Verilator 5 or newer, and g++")
    has_ghdl mcode || missing+=("GHDL 2.0 or newer with the mcode code generator")
    has_ghdl llvm || missing+=("GHDL 2.0 or newer with the LLVM code generator (GHDL_BACKEND=llvm)")
    "$PYTHON" -c 'import ensurepip, sysconfig, venv
raise SystemExit(not sysconfig.get_config_var("Py_ENABLE_SHARED"))' 2>/dev/null ||
        missing+=("Python 3.11 or newer with venv and a shared libpython, as $PYTHON or PYTHON=...")
    [ ${#missing[@]} -eq 0 ] && return
    give_up "This system ($(system_name)) is not one of Debian 12, Debian 13 and Ubuntu 24.04." \
        "Install these, then start again:" "" "${missing[@]/#/- }" "" \
        "(Debian's names of the packages: ${PACKAGES[*]})"
}

check_python() {
    "$PYTHON" -c 'import sys; raise SystemExit(sys.version_info < (3, 11))' 2>/dev/null ||
        give_up "$PYTHON is not Python 3.11 or newer." \
            "Install python3 and python3-venv from the system's packages, or name another:" "" \
            "PYTHON=/usr/bin/python3.12 make setup"
}

checksum() { sha256sum "$1" | cut -d ' ' -f 1; }

# Tells whether .venv was made with this Python and in this folder.
venv_fits() {
    [ "$(.venv/bin/python -c "$VERSION" 2>/dev/null)" = "$("$PYTHON" -c "$VERSION")" ] &&
        head -n 1 .venv/bin/pip 2>/dev/null | grep -qF "$PWD/.venv/bin/"
}

VERSION='import sys; print(*sys.version_info[:2], sep=".")'

install_python_packages() {
    local stamp=.venv/.setup-lock
    local wanted
    wanted="$(checksum requirements.lock) $("$PYTHON" -c "$VERSION") $PWD"
    if [ -x .venv/bin/python ] && [ "$(cat "$stamp" 2>/dev/null)" = "$wanted" ]; then
        return
    fi
    # A .venv without a stamp may come from an interrupted run of this script, which this run then
    # completes.
    if [ -e .venv ] && { [ -e "$stamp" ] || ! venv_fits; }; then
        say "making .venv anew: the lock file, the Python or the folder has changed"
        rm -rf .venv
    fi
    mkdir -p "$(dirname "$LOG")"
    if [ ! -e .venv ] && ! "$PYTHON" -m venv .venv >"$LOG" 2>&1; then
        log_tail
        rm -rf .venv
        give_up "$PYTHON could not make .venv." "Install the system package python3-venv."
    fi
    say "installing the Python packages of requirements.lock into .venv (a minute or two)"
    # Python compiles a module when a program first imports it; to compile all 17,000 modules here
    # would take a minute.
    if ! .venv/bin/python -m pip install --no-input --no-compile --disable-pip-version-check \
        --only-binary :all: --require-hashes -r requirements.lock >"$LOG" 2>&1; then
        log_tail
        give_up "The Python packages could not be installed (is there a network?)." \
            "They come from pypi.org or from the index that pip is configured for. Start again, or:" \
            "" ".venv/bin/python -m pip install --require-hashes -r requirements.lock"
    fi
    printf '%s\n' "$wanted" >"$stamp"
    rm -f .venv/.setup-package
}

# Installs this package in editable mode; this needs no network.
install_package() {
    local stamp=.venv/.setup-package
    local wanted
    wanted=$(checksum pyproject.toml)
    [ "$(cat "$stamp" 2>/dev/null)" = "$wanted" ] && return
    mkdir -p "$(dirname "$LOG")"
    if ! .venv/bin/python -m pip install --no-input --disable-pip-version-check --no-deps --no-index \
        --no-build-isolation --editable . >"$LOG" 2>&1; then
        log_tail
        give_up "The package arctrue could not be installed into .venv; see $LOG."
    fi
    printf '%s\n' "$wanted" >"$stamp"
    say "ready"
}

# Netlists need GHDL 5 or newer for the reason in sim/arctrue/base/netlist.py. Without it everything
# works except the virtual instrument and its tests.
install_netlist_ghdl() {
    local ghdl
    for ghdl in build/ghdl5/bin/ghdl ghdl; do
        case $("$ghdl" --version 2>/dev/null) in
        "GHDL "[5-9].* | "GHDL "[1-9][0-9].*) return ;;
        esac
    done
    scripts/install_ghdl_netlist.sh ||
        say "setup continues without GHDL 5; the virtual instrument and its tests need it"
}

# Ubuntu 24.04's ghdl-llvm loads libLLVM-18.so.18.1, but Ubuntu's own package of LLVM installs this
# library as libLLVM.so.18.1. Without a link with the first name, ghdl-llvm cannot compile anything.
name_llvm_for_ghdl() {
    local wanted library
    wanted=$(ldd "$GHDL_LLVM" 2>/dev/null | grep -oE 'libLLVM-[0-9]+\.so\.[0-9.]+ => not found') || return 0
    wanted=${wanted%% *}
    library=$(ldconfig -p | grep -oE "/[^ ]*/libLLVM\.so\.${wanted#*.so.}\$" | head -n 1) ||
        give_up "GHDL's LLVM code generator needs $wanted, and this system has none." \
            "Install LLVM ${wanted##*.so.}'s library, then start again. This shows the missing libraries:" \
            "" "ldd $GHDL_LLVM"
    mkdir -p "$LLVM_NAMES"
    ln -sfn "$library" "$LLVM_NAMES/$wanted"
}

case $(system_name) in
"debian 12" | "debian 13")
    # Tests of the page need Chromium. On Ubuntu these tests are skipped, because Ubuntu's package
    # only installs a snap.
    PACKAGES+=(chromium)
    install_packages
    ;;
"ubuntu 24.04") install_packages ;;
*) check_tools ;;
esac
name_llvm_for_ghdl
check_python
install_python_packages
install_package
install_netlist_ghdl
