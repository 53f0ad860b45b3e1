"""Loads firmware or bitstream into the chip over JTAG: ``make flash``, ``make flash-bitstream``.

gdb writes the firmware into the on-chip memory, reads it back, compares it and starts it; gdb
connects to OpenOCD, or to the server that ``--remote`` names. OpenOCD writes the bitstream into the
fabric. The chip loses firmware and bitstream when it is switched off; a boot image in the flash
remains (``make image``).
"""

from __future__ import annotations

import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import click

ROOT = Path(__file__).resolve().parent.parent
JTAG = ROOT / "scripts" / "jtag"
# gdb communicates with OpenOCD through a pipe. OpenOCD's ports stay closed, because another OpenOCD
# may use them.
ONLY_THE_PIPE = "gdb_port pipe; telnet_port disabled; tcl_port disabled"
GDB_REMOTE_SECONDS = 30
ONBOARD_ADAPTER = JTAG / "ft2232h.cfg"
SECONDS = 120.0

# Each pair has a part of OpenOCD's message, and advice for the user at the board.
ADVICE = (
    ("unable to open ftdi device", "is the board's USB cable in, and is the board on?"),
    ("LIBUSB_ERROR_ACCESS", "no right to the USB device: install OpenOCD's udev rules"),
    ("all zeroes", "the scan chain is silent: is the board's power on?"),
    ("all ones", "the scan chain is silent: is the board's power on?"),
    ("UNEXPECTED", "another chip answers: is it an XC7Z020?"),
    ("Connection refused", "nothing listens there: is the server started?"),
)


class FlashError(Exception):
    """Raised if a command fails; the message states what failed, for the user at the board."""


def tool(names: tuple[str, ...], package: str) -> str:
    """Return the first of the programs that is installed.

    Raises:
        FlashError: none is installed.
    """
    for name in names:
        if found := shutil.which(name):
            return found
    raise FlashError(f"{' or '.join(names)} is not on PATH: apt-get install {package}")


def existing(path: Path, made_by: str) -> Path:
    """Return ``path``. Raises FlashError if there is no such file."""
    if not path.is_file():
        raise FlashError(f"{path}: there is no such file; {made_by} makes it")
    return path


def run(command: list[str], seconds: float) -> str:
    """Run the command; return its whole output.

    Raises:
        FlashError: the command fails, or takes more than ``seconds``.
    """
    try:
        done = subprocess.run(
            command,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            stdin=subprocess.DEVNULL,
            text=True,
            errors="replace",
            check=False,
            timeout=seconds,
        )
    except subprocess.TimeoutExpired as error:
        said = (error.stdout or b"").decode("utf-8", "replace")
        raise FlashError(f"not finished after {seconds:.0f} s\n{last_lines(said)}") from error
    if done.returncode:
        raise FlashError(f"{Path(command[0]).name} gave up\n{last_lines(done.stdout)}")
    return done.stdout


def last_lines(said: str) -> str:
    """Return the last lines of a tool's output, and the advice that belongs to its message."""
    lines = [f"  {line}" for line in said.strip().splitlines()[-12:]]
    lines += [f"  -> {advice}" for sign, advice in ADVICE if sign.lower() in said.lower()]
    return "\n".join(lines)


def load_firmware(
    elf: Path, adapter: Path, remote: str | None, seconds: float = SECONDS
) -> tuple[int, int]:
    """Load the firmware, compare the memory and start; return the numbers of bytes and sections
    that gdb found equal.

    Raises:
        FlashError: a tool or file is missing, nothing answers, or the loaded memory differs.
    """
    gdb = tool(("gdb-multiarch", "arm-none-eabi-gdb"), "gdb-multiarch")
    existing(elf, "make firmware")
    command = [gdb, "--batch", "--nx", "-ex", f"set remotetimeout {GDB_REMOTE_SECONDS}"]
    if remote is None:
        server = [tool(("openocd",), "openocd"), "-f", str(adapter)]
        server += ["-f", str(JTAG / "processor.cfg"), "-c", ONLY_THE_PIPE]
        command += ["-ex", f"target extended-remote | {shlex.join(server)}"]
        command += ["-ex", "monitor restart_to_boot_rom"]
    else:
        command += ["-ex", f"target extended-remote {remote}"]
    said = run([*command, "-x", str(JTAG / "start_firmware.gdb"), str(elf)], seconds)
    size = re.search(r"load size (\d+)", said)
    equal = len(re.findall(r"range 0x[0-9a-f]+ -- 0x[0-9a-f]+: matched", said))
    if "MIS-MATCHED" in said:
        raise FlashError(f"the memory read back differs from the file\n{last_lines(said)}")
    if size is None or equal == 0:
        raise FlashError(f"nothing was loaded\n{last_lines(said)}")
    return int(size[1]), equal


def load_bitstream(bitstream: Path, adapter: Path, seconds: float = SECONDS) -> None:
    """Configure the fabric with a bitstream, by OpenOCD.

    Raises:
        FlashError: a tool or file is missing, or the chip does not answer.
    """
    existing(bitstream, "make bitstream")
    command = [tool(("openocd",), "openocd"), "-f", str(adapter), "-f", str(JTAG / "fabric.cfg")]
    # Tcl does not interpret text between braces.
    run([*command, "-c", f"load_bitstream {{{bitstream.resolve()}}}"], seconds)


@click.group(help=(__doc__ or "").splitlines()[0])
def main() -> None:
    """Define the commands ``firmware`` and ``fabric``, which share the option for the adapter."""


@main.command()
@click.argument("elf", type=click.Path(path_type=Path))
@click.option("--adapter", type=click.Path(path_type=Path), default=ONBOARD_ADAPTER)
@click.option("--remote", help="a gdb server, host:port or a socket's path, in place of OpenOCD")
def firmware(elf: Path, adapter: Path, remote: str | None) -> None:
    """Load ELF into the on-chip memory and start it."""
    size, equal = load_firmware(elf, adapter, remote)
    click.echo(f"{elf}: {size} bytes loaded, {equal} sections read back equal; started")


@main.command()
@click.argument("bitstream", type=click.Path(path_type=Path))
@click.option("--adapter", type=click.Path(path_type=Path), default=ONBOARD_ADAPTER)
def fabric(bitstream: Path, adapter: Path) -> None:
    """Load BITSTREAM into the fabric."""
    load_bitstream(bitstream, adapter)
    click.echo(f"{bitstream}: loaded into the fabric")


if __name__ == "__main__":
    try:
        main.main(standalone_mode=False)
    except (FlashError, click.ClickException) as error:
        sys.exit(f"error: {error}")
