"""``arctrue flash PORT BOOT.BIN``: writes a boot image into the flash of a running device."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from arctrue.base.percent import percent
from arctrue.base.read_errors import unreadable
from arctrue.cli._device import console_at
from arctrue.cli._progress import Progress
from arctrue.cli._terminal import say, tell_error
from arctrue.device.console import ConsoleError
from arctrue.device.flash import FlashRefusedError, write_image

REFUSED = 1
NO_DEVICE = 2


@click.command(short_help="Write a boot image into a device's flash.")
@click.argument("port")
@click.argument("file", metavar="BOOT.BIN", type=click.Path(path_type=Path))
def flash(port: str, file: Path) -> None:
    """Write BOOT.BIN, a file made by make image, into the flash of the board at PORT.

    The device continues its work meanwhile. It writes the first image of a board twice: the second
    copy is the golden image, which is never overwritten. If power is lost during the writing, the
    board starts the golden image. An image of the firmware alone takes a minute, a bitstream about
    twenty minutes more.

    Exit code 1: the device refuses the image. 2: the file cannot be read, or the device does not
    answer.
    """
    try:
        image = file.read_bytes()
        console = console_at(port)
        with Progress(f"{file.name}: writing") as progress:
            state = write_image(
                console,
                image,
                lambda done, all_: progress.now(
                    f"{file.name}: {done:,} of {all_:,} bytes, {percent(done / all_)}"
                ),
            )
    except FlashRefusedError as error:
        tell_error(f"{file}: {error}")
        sys.exit(REFUSED)
    except OSError as error:
        tell_error(f"{file}: {unreadable(error)}")
        sys.exit(NO_DEVICE)
    except ConsoleError as error:
        tell_error(str(error))
        sys.exit(NO_DEVICE)
    golden = "the golden image is unchanged" if state.has_golden else "it is the golden image, too"
    say(f"{file}: written and read back; {golden}. The image starts at the next power-on")
