"""Converts the date of a measurement set from a text in ISO 8601, as in measurement.toml, to a
datetime with a time zone."""

from __future__ import annotations

from datetime import UTC, date, datetime
from typing import Any


def moment(text: str, key: str = "date") -> datetime:
    """Return the instant that a text in ISO 8601 states; a text without a time zone counts as UTC.

    A date without a time means the beginning of the day. Raises ValueError, whose text begins with
    ``key``.
    """
    try:
        found = datetime.fromisoformat(text)
    except ValueError:
        raise ValueError(
            f"{key}: expected a date such as 2026-03-12 or 2026-03-12T09:30:00+01:00, "
            f"found {text[:60]!r}"
        ) from None
    return found if found.tzinfo is not None else found.replace(tzinfo=UTC)


def with_text_date(content: dict[str, Any]) -> dict[str, Any]:
    """Return the content of a TOML file with ``date`` as text; TOML may also store it as a date."""
    given = content.get("date")
    return {**content, "date": given.isoformat()} if isinstance(given, date) else content
