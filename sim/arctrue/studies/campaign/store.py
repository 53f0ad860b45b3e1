"""Reads and writes the folder of a campaign: a header, one JSON line per result, and the timings in
separate files."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

from arctrue.base.read_errors import unreadable
from arctrue.base.typed_content import ContentError, read_json, typed_json
from arctrue.base.whole_file import write_whole_text
from arctrue.studies.campaign.task import Task, canonical, task_key

HEADER = "campaign.json"
COMMIT = "commit"
"""Key of the commit. The commit is recorded but not compared, because two commits may have the same
source."""


class StoreError(ValueError):
    """Raised if the folder holds another campaign, or contradictory results."""


@dataclass(frozen=True, slots=True)
class Result:
    """Finished task with its result.

    Parameters
    ----------
    key : str
        Key of the task.
    task : mapping
        Argument of the work.
    result : mapping
        Return value of the work.
    """

    key: str
    task: Task
    result: Mapping[str, Any]

    def line(self) -> str:
        """Format the result as one line of a file.

        Returns
        -------
        str
            JSON without a line break.
        """
        return canonical({"key": self.key, "task": self.task, "result": self.result})


class Store:
    """Context manager that appends the results of one shard to a campaign's folder.

    Parameters
    ----------
    folder : Path
        The campaign's folder.
    header : mapping of str to object
        Values that identify the campaign and the state of the code.
    shard : str, optional
        Ending of the names of this shard's files.
    """

    def __init__(self, folder: Path, header: Mapping[str, Any], shard: str = "") -> None:
        """Open or create the folder.

        Raises StoreError if the folder belongs to another campaign or another state of the code.
        """
        folder.mkdir(parents=True, exist_ok=True)
        _check_header(folder, header)
        self.folder = folder
        # Bytes after the last complete line belong to a line that a crash cut off.
        self._results = _open(folder / f"results{shard}.jsonl")
        self._timings = _open(folder / f"timings{shard}.jsonl")
        self.done = {item.key for item in read_results([folder])}

    def __enter__(self) -> Self:
        """Return the store itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close the file of results and the file of timings."""
        self._results.close()
        self._timings.close()

    def add(self, task: Task, result: Mapping[str, Any], seconds: float) -> None:
        """Write one result to the disk before returning; ignore a second result with the same key.

        Parameters
        ----------
        task : mapping
            The finished task.
        result : mapping
            Return value of the work.
        seconds : float
            Time that the work took.
        """
        key = task_key(task)
        if key in self.done:
            return
        self._results.write(Result(key, task, result).line() + "\n")
        self._results.flush()
        self._timings.write(canonical({"key": key, "seconds": round(seconds, 3)}) + "\n")
        self._timings.flush()
        self.done.add(key)


def _check_header(folder: Path, header: Mapping[str, Any]) -> None:
    path = folder / HEADER
    text = json.dumps(header, indent=1, sort_keys=True, ensure_ascii=False) + "\n"
    # The header is written under another name and then linked: if two shards start at once, only
    # one link succeeds.
    mine = folder / f".{HEADER}.{os.getpid()}"
    write_whole_text(mine, text)
    try:
        os.link(mine, path)
    except FileExistsError:
        found = read_header(folder)
        for name, value in header.items():
            if name != COMMIT and found.get(name) != json.loads(canonical(value)):
                raise StoreError(
                    f"{path}: {name} is {_short(found.get(name))}, the present run has "
                    f"{_short(value)}: results of two states are not mixed; take a new folder"
                ) from None
    finally:
        mine.unlink()


def _short(value: object) -> str:
    text = canonical(value)
    return text if len(text) < 200 else text[:200] + " …"


def read_header(folder: Path) -> dict[str, Any]:
    """Read the header of a campaign's folder. Raises StoreError if there is none."""
    path = folder / HEADER
    try:
        return read_json(path, dict[str, Any])
    except OSError as error:
        why = unreadable(error, f"no campaign has been run in {folder}")
        raise StoreError(f"{path}: {why}") from None
    except ContentError as error:
        raise StoreError(str(error)) from None


def stated_code(header: Mapping[str, Any]) -> str:
    """Describe the state of the code that made the results."""
    made_by = header.get(COMMIT)
    words = f"Commit `{made_by}`" if made_by else "No commit known"
    return f"{words}, source `{header['code']['arctrue']}`"


def _compared(header: Mapping[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in header.items() if name != COMMIT}


def _open(path: Path) -> Any:
    if path.exists():
        whole = path.read_bytes()
        if whole and not whole.endswith(b"\n"):
            with path.open("r+b") as file:
                file.truncate(whole.rfind(b"\n") + 1)
    return path.open("a", encoding="utf-8")


def read_results(folders: Iterable[Path]) -> list[Result]:
    """Read all results of the folders (shards of one campaign), by key.

    Parameters
    ----------
    folders : iterable of Path
        Folders of one campaign.

    Returns
    -------
    list of Result
        The results in the order of their keys.

    Raises
    ------
    StoreError
        The folders have different headers, or one key has two results.
    """
    found: dict[str, Result] = {}
    first: tuple[Path, dict[str, Any]] | None = None
    for folder in folders:
        header = read_header(folder)
        if first is not None and _compared(header) != _compared(first[1]):
            raise StoreError(f"{folder} and {first[0]} are different campaigns or states of code")
        first = first or (folder, header)
        for path, number, result in _lines(folder):
            earlier = found.setdefault(result.key, result)
            if earlier.line() != result.line():
                raise StoreError(
                    f"{path}, line {number}: a second, different result for {result.key}"
                )
    return [found[key] for key in sorted(found)]


def _lines(folder: Path) -> Iterator[tuple[Path, int, Result]]:
    for path in sorted(folder.glob("results*.jsonl")):
        text = path.read_text(encoding="utf-8")
        for number, line in enumerate(text.splitlines(keepends=True), start=1):
            if not line.endswith("\n"):
                # A crash cut this line off; it is ignored, so its task is done again.
                continue
            try:
                yield path, number, typed_json(line, Result, f"{path}, line {number}")
            except ContentError as error:
                raise StoreError(str(error)) from None


def merge(folders: Iterable[Path], into: Path) -> int:
    """Merge folders into one with a single file ordered by key; return the number of results.

    The bytes of the file depend neither on the machines that computed the results nor on the time.
    """
    listed = list(folders)
    results = read_results(listed)
    into.mkdir(parents=True, exist_ok=True)
    _check_header(into, read_header(listed[0]))
    text = "".join(item.line() + "\n" for item in results)
    write_whole_text(into / "results.jsonl", text)
    return len(results)
