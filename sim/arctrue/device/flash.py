"""Writes a boot image into the flash of a running device, over the device's console.

The boot ROM starts the first image that it finds: it looks for a header every 32 KB, beginning at
the start of the flash (UG585, chapter 6). The image at the start is updated; the golden image after
it is written once and then remains. The signature in the header of an image is overwritten before
the image is erased, and the header is written last. Power may therefore be lost at any moment, also
during an erase: until the header of the first image is complete, the golden image starts. The
bitstream after the images has its own CRC; the firmware starts even if the bitstream is damaged.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass

from arctrue.base.progress import ReportCount
from arctrue.device.console import Console, ConsoleError
from arctrue.device.refusal import explained, reason_of

GOLDEN = 0x4_0000
"""Address of the golden image, and largest length of each of the two images, bytes; flash_map.h of
firmware/zynq has the same values."""
BITSTREAM = 0x10_0000
END = 0xF0_0000
PAGE_BYTES = 256
WORD_BYTES = 4
LINE_WORDS = 6
CHECKED_BYTES = 0x1_0000
ERASED = b"\xff"
HEADER_BYTES = 0x8C0
SIGNATURE_AT, SIGNATURE = 0x24, b"XNLX"
CHECKED_LAST = 4 * LINE_WORDS * WORD_BYTES
"""Number of bytes at the image's start that contain the width detection word, the signature and the
check sum; they are written last."""
ATTEMPTS = 3
"""Number of attempts to send a line if it is damaged in transmission."""
ERASE_S = 15.0


class FlashRefusedError(Exception):
    """Is raised if the image or the flash cannot be used; the message states the reason and the
    remedy."""


@dataclass(frozen=True)
class FlashState:
    """State of the flash, as the device reports it."""

    has_golden: bool
    sector_bytes: int
    started_from: int


def parts_of(image: bytes) -> tuple[bytes, bytes]:
    """Divide an image into boot image and bitstream, each without erased bytes at its end.

    Raises FlashRefusedError for a file that ``make image`` did not write.
    """
    boot, fabric = image[:GOLDEN].rstrip(ERASED), image[BITSTREAM:].rstrip(ERASED)
    if boot[SIGNATURE_AT : SIGNATURE_AT + 4] != SIGNATURE or len(boot) <= HEADER_BYTES:
        raise FlashRefusedError(
            "it does not begin with the boot ROM's header; expected the BOOT.BIN of make image"
        )
    if len(image) > END:
        raise FlashRefusedError(
            f"it has {len(image):,} bytes; expected at most {END:,}, because the device saves "
            "its settings behind this address"
        )
    return boot, fabric


def lines_of(data: bytes, address: int, first: int = 0, last: int | None = None) -> Iterator[str]:
    """Yield the console lines that write ``data[first:last]``; the byte ``data[0]`` has the address
    ``address``.

    A line has at most 24 bytes of data and ends at the end of a page; a line whose bytes all equal
    erased flash is omitted.
    """
    step = LINE_WORDS * WORD_BYTES
    end = len(data) if last is None else min(last, len(data))
    place = first
    while place < end:
        page_end = place - (address + place) % PAGE_BYTES + PAGE_BYTES
        stop = min(place + step, page_end, end)
        words = data[place:stop].ljust(-(place - stop) // WORD_BYTES * WORD_BYTES, ERASED)
        words += ERASED * (-len(words) % WORD_BYTES)
        if words.strip(ERASED):
            values = struct.unpack(f"<{len(words) // WORD_BYTES}I", words)
            crc = zlib.crc32(struct.pack("<I", address + place) + words)
            digits = "".join(f"{value:08X}" for value in values)
            yield f"flash data {address + place:X} {digits} {crc:08X}"
        place = stop


def state_of(console: Console) -> FlashState:
    """Return the state of the flash. Raises FlashRefusedError if the device has no supported
    flash."""
    answers = dict(line.split(" ", 1) for line in _ask(console, "flash status") if " " in line)
    state = FlashState(
        answers.get("golden") == "whole",
        int(answers.get("sector_bytes", "0")),
        int(answers.get("started_from", "0"), 16),
    )
    if not state.sector_bytes:
        raise FlashRefusedError("the device does not support the flash with this ID")
    return state


def write_image(console: Console, image: bytes, report_count: ReportCount) -> FlashState:
    """Write a whole BOOT.BIN, and return the state of the flash before the writing.

    ``report_count`` receives the number of written bytes and the total number of bytes. A golden
    image is written first if there is none. Raises FlashRefusedError, ConsoleError.
    """
    boot, fabric = parts_of(image)
    state = state_of(console)
    areas = [] if state.has_golden else [(boot, GOLDEN)]
    if fabric:
        areas.append((fabric, BITSTREAM))
    areas.append((boot, 0))
    all_bytes = sum(len(data) for data, _ in areas)
    done = 0
    for data, address in areas:
        if data is boot:
            # After an interrupted erase, the header may be intact although the image behind it is
            # not.
            for line in lines_of(bytes(WORD_BYTES), address + SIGNATURE_AT):
                _send(console, line)
        for sector in range(address, address + len(data), state.sector_bytes):
            _ask(console, f"flash erase {sector:X}", ERASE_S)
        # The bytes that make the boot ROM accept the image are written last.
        for first, last in ((CHECKED_LAST, len(data)), (0, CHECKED_LAST)):
            for line in lines_of(data, address, first, last):
                _send(console, line)
                report_count(done + int(line.split()[2], 16) - address, all_bytes)
            _compare(console, data, address, first, last)
        done += len(data)
    report_count(all_bytes, all_bytes)
    return state


def _compare(console: Console, data: bytes, address: int, first: int, last: int) -> None:
    whole = data[:last] + ERASED * (-len(data[:last]) % WORD_BYTES)
    for place in range(first, len(whole), CHECKED_BYTES):
        part = whole[place : place + CHECKED_BYTES]
        answer = _ask(console, f"flash check {address + place:X} {len(part):X}")
        if answer[0] != f"crc {zlib.crc32(part):08X}":
            raise FlashRefusedError(
                f"the flash from {address + place:#x} on does not contain the sent data; does "
                "another program write to the flash?"
            )


def _send(console: Console, line: str) -> None:
    for attempt in range(1, ATTEMPTS + 1):
        try:
            console.command(line)
        except ConsoleError as error:
            if reason_of(error, "flash") != "wrong_crc" or attempt == ATTEMPTS:
                raise _refused(console, error) from error
        else:
            return


def _ask(console: Console, line: str, seconds: float = 5.0) -> list[str]:
    try:
        return console.command(line, seconds)
    except ConsoleError as error:
        raise _refused(console, error) from error


def _refused(console: Console, error: ConsoleError) -> Exception:
    reason = reason_of(error, "flash")
    return error if reason is None else FlashRefusedError(explained(console, reason))
