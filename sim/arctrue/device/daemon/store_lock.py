"""Reserves a folder for one program: a store, whose record has the turns of one device only, or the
folder of the daily files."""

from __future__ import annotations

import fcntl
import os
from pathlib import Path

from arctrue.base.whole_file import ORDINARY_MODE
from arctrue.device.port import ConsoleError

_MOST_BYTES = 4096


class StoreLock:
    """A lock of a folder, which the system releases when the program ends, even if it is killed.

    On a file system without locks the folder is not locked.
    """

    def __init__(
        self,
        folder: Path,
        owner: str,
        remedy: str = "name another folder: --store",
        name: str = "lock",
    ) -> None:
        """Lock the folder for ``owner``, a program's name; ``name``: file that holds the lock.

        Raises ConsoleError, which names the other program that has the folder, or OSError.
        """
        self._file = os.open(folder / name, os.O_RDWR | os.O_CREAT, ORDINARY_MODE)
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            other = os.read(self._file, _MOST_BYTES).decode("utf-8", "replace")
            os.close(self._file)
            raise ConsoleError(
                f"{folder}: is in use by {other or 'another program'}; {remedy}"
            ) from error
        except OSError:
            return
        os.ftruncate(self._file, 0)
        os.write(self._file, f"{owner} (process {os.getpid()})".encode())

    @classmethod
    def of_files(cls, folder: Path, owner: str, remedy: str) -> StoreLock:
        """Lock a folder of daily files, which may also be a store."""
        return cls(folder, owner, remedy, ".arctrue-files-lock")

    def release(self) -> None:
        """Let another program use the folder."""
        os.close(self._file)
