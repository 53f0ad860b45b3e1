"""ArcTrue: the true angle of a rotary table from two read heads.

``import arctrue as at`` gives ``at.read_set``, ``at.compare``, ``at.diagnose``, ``at.simulate`` and
``at.Model`` (``arctrue.api``); they are imported when they are first used.
"""

import importlib
import os
from typing import Any

# The fits multiply blocks of some 40 columns: a second thread of the linear algebra brings
# nothing there, and where another program wants the core too, waiting for it takes ten times as
# long as the work. numpy reads this when it is first imported.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

_OF_THE_API = ("Model", "compare", "diagnose", "read_set", "simulate")


def __getattr__(name: str) -> Any:
    """What the API has under ``name``. Raises AttributeError for any other name."""
    if name not in _OF_THE_API:
        raise AttributeError(f"module 'arctrue' has no attribute {name!r}")
    return getattr(importlib.import_module("arctrue.api"), name)


def __dir__() -> list[str]:
    """The names that ``help`` and completion show."""
    return sorted([*globals(), *_OF_THE_API])
