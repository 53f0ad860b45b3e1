"""Files that are written whole or not at all."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

ORDINARY_MODE = 0o666
"""Of a new file, less the process's umask; a temporary file is for its owner only."""


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Give a temporary file beside ``path``, which replaces ``path`` when the block ends well.

    Where the block fails, the temporary file is deleted and ``path`` stays as it was. The folder
    of ``path`` is made. The temporary name has the ending of ``path``, from which matplotlib takes
    the format. Raises OSError, with ``path`` as its file name, for what cannot be written: a full
    disk gives the writing libraries' error none.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        # A link stays a link: the file that it names is replaced.
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
            raise  # of another file, or of a folder on the way
        raise OSError(
            error.errno, os.strerror(error.errno) if error.errno else str(error), str(path)
        ) from error


def write_whole_text(path: Path, text: str, encoding: str = "utf-8") -> None:
    """Write ``text`` to ``path``, whole or not at all. Raises OSError with the file's name."""
    with whole_file(path) as unfinished:
        unfinished.write_text(text, encoding=encoding)


def _prefix(target: Path) -> str:
    return f".{target.stem[:64]}."


def _reach_the_disk(path: Path) -> None:
    """Ask for all of the file on the disk: some file systems tell only then that it is full."""
    with path.open("rb") as file:
        os.fsync(file.fileno())


def _umask() -> int:
    """The process's umask, which can only be read by setting it."""
    present = os.umask(0o077)
    os.umask(present)
    return present
