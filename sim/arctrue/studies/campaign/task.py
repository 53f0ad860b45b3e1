"""What is to be done: a task, its key, and the function that does it."""

from __future__ import annotations

import hashlib
import importlib
import json
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any

Task = Mapping[str, Any]
Work = Callable[[Task], Mapping[str, Any]]


def canonical(value: object) -> str:
    """JSON with sorted keys and no spaces: the same text for the same content.

    Raises ValueError for a number that is not finite.
    """
    return json.dumps(
        value, sort_keys=True, separators=(",", ":"), ensure_ascii=False, allow_nan=False
    )


def digest(value: object) -> str:
    """SHA-256 of the canonical JSON, in hex."""
    return hashlib.sha256(canonical(value).encode()).hexdigest()


def task_key(task: Task) -> str:
    """The key of a task: the first 24 hex digits of its content's digest."""
    return digest(task)[:24]


def find_work(name: str) -> Work:
    """The function of ``module:function``."""
    module, _, function = name.partition(":")
    found: Work = getattr(importlib.import_module(module), function)
    return found


def do_batch(work: str, tasks: Sequence[Task]) -> list[tuple[Mapping[str, Any], float]]:
    """Result and seconds of each task, one after the other; runs in a worker."""
    function = find_work(work)
    found = []
    for task in tasks:
        begin = time.perf_counter()
        found.append((function(task), time.perf_counter() - begin))
    return found
