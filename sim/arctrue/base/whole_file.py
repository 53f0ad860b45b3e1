"""Writes files completely or not at all."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

ORDINARY_MODE = 0o666
"""Mode of a new file, reduced by the umask; it replaces the mode of the temporary file, which only
its owner can read."""


@contextmanager
def whole_file(path: Path, *, make_folder: bool = True) -> Iterator[Path]:
    """Yield a temporary file next to ``path``, which replaces ``path`` if the block succeeds.

    If the block fails, the temporary file is deleted and ``path`` stays unchanged. Missing folders
    are made if ``make_folder`` is set. The temporary name ends like ``path``, because matplotlib
    takes the format from it. Raises OSError with ``path`` as file name: on a full disk, a library's
    own error would contain no file name.
    """
    try:
        if make_folder:
            path.parent.mkdir(parents=True, exist_ok=True)
        # If path is a link, the file to which it leads is replaced.
        target = path.resolve()
        mode = target.stat().st_mode & 0o777 if target.exists() else ORDINARY_MODE & ~_umask()
        handle, name = tempfile.mkstemp(
            prefix=_prefix(target), suffix=target.suffix, dir=target.parent
        )
        os.close(handle)
        unfinished = Path(name)
        try:
            yield unfinished
            _reach_the_disk(unfinished)
            unfinished.chmod(mode)
            unfinished.replace(target)
        finally:
            unfinished.unlink(missing_ok=True)
    except OSError as error:
        named = Path(error.filename).name if isinstance(error.filename, str) else ""
        if named and not named.startswith(_prefix(path.resolve())):
            raise  # the error concerns another file, or a folder on the path
        raise OSError(
            error.errno, os.strerror(error.errno) if error.errno else str(error), str(path)
        ) from error


def write_whole_text(path: Path, text: str, *, make_folder: bool = True) -> None:
    """Write ``text`` to ``path`` completely or not at all. Raises OSError with the file name."""
    with whole_file(path, make_folder=make_folder) as unfinished:
        unfinished.write_text(text, encoding="utf-8")


def _prefix(target: Path) -> str:
    return f".{target.stem[:64]}."


def _reach_the_disk(path: Path) -> None:
    """Flush the file to the disk: some file systems report a full disk only then."""
    with path.open("rb") as file:
        os.fsync(file.fileno())


def _umask() -> int:
    """Read the umask of the process; the system returns it only when a new one is set."""
    present = os.umask(0o077)
    os.umask(present)
    return present
