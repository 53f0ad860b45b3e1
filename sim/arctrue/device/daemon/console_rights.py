"""Lists the console lines that change nothing in the device (except that one of them switches
telemetry on); a read-only daemon forwards only these lines."""

from __future__ import annotations

import re

_READS = re.compile(
    rb"\s*(|status|version|heads|help( \w+)?|show \w+|dump( rows \d+ \d+)?|probe( events)?"
    rb"|trigger|sync|compare|load status|flash status|telemetry on|marker[\d.]+)\s*"
)


def refusal_of(line: bytes) -> str | None:
    """Return None for a line that only reads; otherwise return the reason why the daemon refuses
    the line."""
    if _READS.fullmatch(line):
        return None
    return "read-only; start arctrue device run with --allow-control to change the device"
