"""States errors of files in the words of all commands and pages."""

from __future__ import annotations


def unreadable(error: OSError, remedy: str = "") -> str:
    """Return why a file cannot be read, without its name; ``remedy`` is for a missing file."""
    if isinstance(error, FileNotFoundError):
        return f"no such file{remedy and '; '}{remedy}"
    return f"cannot be read: {error.strerror}"


def sentence(error: Exception) -> str:
    """Return an error as one sentence, with the file that cannot be read or written."""
    if isinstance(error, OSError) and error.filename is not None and error.strerror:
        return f"{error.filename}: cannot be read or written: {error.strerror}"
    return str(error) or type(error).__name__
