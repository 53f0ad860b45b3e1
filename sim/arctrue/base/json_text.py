"""Converts results to JSON, which has no NaN and no infinity (RFC 8259)."""

from __future__ import annotations

import json
import math
from typing import Any


def plain(value: Any) -> Any:
    """Convert numpy numbers to Python numbers, and NaN and infinity to None."""
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if hasattr(value, "tolist"):
        return plain(value.tolist())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def json_text(data: Any) -> str:
    """Return a result as the text of a JSON file; numbers that are not finite become null."""
    return json.dumps(plain(data), indent=1, ensure_ascii=False, allow_nan=False) + "\n"
