"""Reserves a store for one daemon, because a record has the turns of one device."""

from __future__ import annotations

import fcntl
import os
from pathlib import Path

from arctrue.device.port import ConsoleError

_MOST_BYTES = 4096


class StoreLock:
    """A lock of a folder, which the system releases when the program ends, even if it is killed.

    On a file system without locks the folder is not locked.
    """

    def __init__(self, folder: Path, port: str) -> None:
        """Lock the folder for the daemon of ``port``.

        Raises ConsoleError, which names the other daemon that has the folder, or OSError.
        """
        self._file = os.open(folder / "lock", os.O_RDWR | os.O_CREAT, 0o600)
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            owner = os.read(self._file, _MOST_BYTES).decode("utf-8", "replace")
            os.close(self._file)
            raise ConsoleError(
                f"{folder}: is in use by {owner or 'another daemon'}; name another folder: --store"
            ) from error
        except OSError:
            return
        os.ftruncate(self._file, 0)
        os.write(self._file, f"arctrue device run {port} (process {os.getpid()})".encode())

    def release(self) -> None:
        """Let another daemon use the folder."""
        os.close(self._file)
