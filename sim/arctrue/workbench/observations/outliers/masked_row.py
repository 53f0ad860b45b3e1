"""Describes a row of a recording that is not used."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Reason = Literal["mask", "outlier", "duplicate"]
"""Reason why a row is not used. "mask": the set masks the row, in a column or in mask.csv;
"outlier": this package has detected the row as an outlier; "duplicate": every column, also the
time, equals that of an earlier row."""


@dataclass(frozen=True)
class MaskedRow:
    """A row that is not used; ``row`` is its line in the file, where the header is line 1."""

    channel: Literal["capture", "reference"]
    row: int
    reason: Reason
    away_arcsec: float | None = None
    """Difference between the row's value and the value that other rows predict: the rows around it,
    or other visits of its station."""

    def data(self) -> dict[str, str | int | float | None]:
        """Return the masked row as JSON."""
        return {
            "channel": self.channel,
            "row": self.row,
            "reason": self.reason,
            "away_arcsec": self.away_arcsec,
        }

    def __str__(self) -> str:
        """Return the masked row in one line for people."""
        away = "" if self.away_arcsec is None else f" ({self.away_arcsec:+.2f}″)"
        return f"{self.channel}.csv, row {self.row}: {self.reason}{away}"
