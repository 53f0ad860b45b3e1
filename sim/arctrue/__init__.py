"""ArcTrue finds the true angle of a rotary table from two read heads.

``import arctrue as at`` gives ``at.Dataset``, ``at.compare``, ``at.diagnose`` and the other names
of ``arctrue.api``; they are imported when they are first used.
"""

import importlib
import os
from typing import Any

# The fits multiply matrices with about 40 columns, which a second BLAS thread does not make faster.
# If another program uses the processor too, waiting for this thread takes ten times as long as the
# product. numpy reads this variable when it is first imported.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
# mimalloc in pyarrow can crash a program if the first thread that used pyarrow has ended, for
# example a server that reads a set for a request (apache/arrow issue 50908). pyarrow reads this
# variable when it first allocates memory.
os.environ.setdefault("ARROW_DEFAULT_MEMORY_POOL", "system")

__all__ = [
    "Comparison",
    "Dataset",
    "Diagnosis",
    "Explanation",
    "ExportRefusedError",
    "FitEstimator",
    "FitParameter",
    "FitParameters",
    "FitResult",
    "Model",
    "ModelTest",
    "Pictures",
    "add",
    "compare",
    "compare_models",
    "diagnose",
    "drop",
    "explain",
    "export",
    "fit",
    "import_files",
    "read_set",
    "simulate",
    "write_set",
]
"""Names of ``arctrue.api``."""


def __getattr__(name: str) -> Any:
    """Return the object that the API has under ``name``. Raises AttributeError for any other
    name."""
    if name not in __all__:
        raise AttributeError(f"module 'arctrue' has no attribute {name!r}")
    return getattr(importlib.import_module("arctrue.api"), name)


def __dir__() -> list[str]:
    """Return the names that ``help`` and completion show."""
    return sorted({*globals(), *__all__})
