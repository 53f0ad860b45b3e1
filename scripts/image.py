"""Writes the boot image of a board's QSPI flash: ``make image``.

The image is the boot ROM's header (UG585, chapter 6, table of the BootROM header), then the
firmware with the bytes that it has in the on-chip memory. The bitstream follows at a separate
offset; the firmware itself loads the bitstream (``firmware/zynq/fabric_image.h``), so the image
needs no first-stage loader and no partition table. The flash holds the boot image twice: the boot
ROM starts the second, golden copy if the first is bad.
"""

from __future__ import annotations

import re
import struct
import subprocess
import sys
import zlib
from pathlib import Path

import click
import numpy as np

ROOT = Path(__file__).resolve().parent.parent
FABRIC_IMAGE = ROOT / "firmware" / "zynq" / "fabric_image.h"
FLASH_MAP = ROOT / "firmware" / "zynq" / "flash_map.h"

WORD_BYTES = 4
ON_CHIP_MEMORY_BYTES = 192 * 1024
BRANCH_TO_ITSELF = 0xEAFF_FFFE
WIDTH_DETECTION = 0xAA99_5566
SIGNATURE = 0x584C_4E58  # "XLNX"
HEADER_VERSION = 0x0101_0000
RESERVED = 0  # the only value that U-Boot's mkimage accepts (its images also boot from QSPI)
FIRST_CHECKED, CHECKSUM = 0x20, 0x48
REGISTER_TABLE, REGISTER_PAIRS = 0xA0, 256
NO_REGISTER = 0xFFFF_FFFF
PROGRAM_OFFSET = (
    0x8C0  # the lowest offset that the boot ROM accepts: after the table, a multiple of 64
)
PROGRAM_ALIGNMENT = 64
ENTRY_ALIGNMENT = 64
ERASED = b"\xff"
SYNC_WORD = struct.pack(">I", 0xAA99_5566)
LONGEST_HEAD = 1024  # largest number of bytes of a .bit before the sync word
# Number of bytes of dummy words and width detection, which the configuration port requires
BEFORE_SYNC = 48


class ImageError(Exception):
    """Raised if no image can be made; the message states the reason for the user."""


def padded(data: bytes, multiple: int) -> bytes:
    """Extend ``data`` with the content of an erased flash to a multiple of ``multiple`` bytes."""
    return data + ERASED * (-len(data) % multiple)


def boot_image(program: bytes, entry: int) -> bytes:
    """Return header and program; the boot ROM loads the program to address 0 and starts it at
    ``entry``.

    Raises:
        ImageError: the program does not fit, or does not start inside itself at a multiple of 64.
    """
    body = padded(program, PROGRAM_ALIGNMENT)
    if len(body) > ON_CHIP_MEMORY_BYTES:
        raise ImageError(
            f"the firmware has {len(body):,} bytes; the boot ROM takes {ON_CHIP_MEMORY_BYTES:,}"
        )
    if not 0 <= entry < len(program):
        raise ImageError(f"the firmware starts at {entry:#x}, outside its {len(program):,} bytes")
    if entry % ENTRY_ALIGNMENT:
        raise ImageError(f"the firmware starts at {entry:#x}, not a multiple of {ENTRY_ALIGNMENT}")
    header = bytearray(PROGRAM_OFFSET)
    struct.pack_into("<8I", header, 0, *[BRANCH_TO_ITSELF] * 8)
    words = (WIDTH_DETECTION, SIGNATURE, 0, HEADER_VERSION, PROGRAM_OFFSET, len(body), 0, entry)
    checked = (*words, len(body), RESERVED)
    struct.pack_into("<10I", header, FIRST_CHECKED, *checked)
    struct.pack_into("<I", header, CHECKSUM, ~sum(checked) & 0xFFFF_FFFF)
    for pair in range(REGISTER_PAIRS):
        struct.pack_into("<2I", header, REGISTER_TABLE + 8 * pair, NO_REGISTER, 0)
    return bytes(header) + body


def header_constants() -> dict[str, int]:
    """Read the constants of the bitstream's header from the source of the firmware."""
    text = FABRIC_IMAGE.read_text("utf-8")
    found = re.findall(r"^#define FABRIC_IMAGE_(\w+) (0x[0-9A-F]+|\d+)U$", text, re.MULTILINE)
    return {name: int(value, 0) for name, value in found}


def flash_map() -> dict[str, int]:
    """Read the addresses of the images in the flash, in bytes, from the source of the firmware."""
    text = FLASH_MAP.read_text("utf-8")
    found = re.findall(r"^#define FLASH_MAP_(\w+) (0x[0-9A-F]+)U$", text, re.MULTILINE)
    return {name: int(value, 0) for name, value in found}


def fabric_image(bitstream: bytes, source: str) -> bytes:
    """Return a header in the form that the firmware reads, followed by the bitstream for the
    configuration port.

    ``bitstream`` is a .bit or a raw .bin, both with the most significant byte of a word first.

    Raises:
        ImageError: there is no synchronisation word near the start.
    """
    start = bitstream.find(SYNC_WORD, 0, LONGEST_HEAD)
    if start < 0:
        raise ImageError(f"{source}: no sync word AA995566 in the first {LONGEST_HEAD} bytes")
    # The text at the start of a .bit may end at any byte; the words before the sync word are always
    # the same.
    before = bitstream[max(0, start - BEFORE_SYNC) : start].rjust(BEFORE_SYNC, ERASED)
    words = padded(before + bitstream[start:], WORD_BYTES)
    swapped = np.frombuffer(words, dtype=">u4").astype("<u4").tobytes()
    constants = header_constants()
    header = struct.pack(
        "<4I", constants["MAGIC"], constants["VERSION"], len(swapped), zlib.crc32(swapped)
    )
    return header.ljust(constants["HEADER_BYTES"], b"\0") + swapped


def flash_image(program: bytes, entry: int, bitstream: bytes | None, source: str = "") -> bytes:
    """Return the whole content of the flash, from its beginning on: both boot images and the
    bitstream.

    Raises:
        ImageError: see ``boot_image`` and ``fabric_image``.
    """
    places = flash_map()
    boot = boot_image(program, entry)
    if len(boot) > places["GOLDEN_BYTES"]:
        raise ImageError(f"the boot image has {len(boot):,} bytes; {places['GOLDEN_BYTES']:,} fit")
    both = boot.ljust(places["GOLDEN"], ERASED) + boot
    if bitstream is None:
        return both
    return both.ljust(places["BITSTREAM"], ERASED) + fabric_image(bitstream, source)


def program_of(elf: Path) -> tuple[bytes, int]:
    """Return the bytes of the on-chip memory from address 0 on, and the firmware's start address.

    Raises:
        ImageError: there is no such file, it is not an ELF of the firmware, or objcopy fails.
    """
    if not elf.is_file():
        raise ImageError(f"{elf}: there is no such file; make firmware makes it")
    data = elf.read_bytes()
    if data[:6] != b"\x7fELF\x01\x01":
        raise ImageError(f"{elf}: not a 32-bit little-endian ELF")
    (entry,) = struct.unpack_from("<I", data, 0x18)
    raw = elf.with_suffix(".bin")
    done = subprocess.run(
        ["arm-none-eabi-objcopy", "-O", "binary", str(elf), str(raw)],
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode:
        raise ImageError(f"{elf}: {done.stderr.strip()}")
    return raw.read_bytes(), entry


@click.command(help=(__doc__ or "").splitlines()[0])
@click.argument("elf", type=click.Path(path_type=Path))
@click.option(
    "--bitstream", type=click.Path(path_type=Path), help="bitstream (.bit or .bin) that is added"
)
@click.option("--out", type=click.Path(path_type=Path), required=True, help="file that is written")
def main(elf: Path, bitstream: Path | None, out: Path) -> None:
    """Write ELF and, if its file exists, the bitstream into one file for the flash."""
    program, entry = program_of(elf)
    data = bitstream.read_bytes() if bitstream and bitstream.is_file() else None
    image = flash_image(program, entry, data, str(bitstream))
    out.parent.mkdir(parents=True, exist_ok=True)
    out.write_bytes(image)
    what = f"firmware of {len(program):,} bytes"
    if data is None:
        missing = f"{bitstream}: there is no such file" if bitstream else "none given"
        what += f", no bitstream ({missing}): the fabric is loaded over JTAG"
    else:
        what += f" and the bitstream {bitstream}"
    click.echo(f"{out}: {len(image):,} bytes, {what}")


if __name__ == "__main__":
    try:
        main.main(standalone_mode=False)
    except (ImageError, click.ClickException) as error:
        sys.exit(f"error: {error}")
