"""Lists the console lines that change neither a setting nor the correction of the device; a
read-only daemon forwards only these lines.

Three of them have another effect: ``telemetry on``; ``dump``, after which a device that samples at
equal angles samples at equal times again; ``probe events``, which removes the printed events from
the gateware's queue.
"""

from __future__ import annotations

import re

_READS = re.compile(
    rb"\s*(|status|version|heads|help( \w+)?|show \w+|dump( rows \d+ \d+)?|probe( events)?"
    rb"|trigger|sync|compare|load status|flash status|telemetry on|marker[\d.]+)\s*"
)


def refusal_of(line: bytes) -> str | None:
    """Return None for a line that the daemon forwards; otherwise return the reason why it refuses
    the line."""
    if _READS.fullmatch(line):
        return None
    return "read-only; start arctrue device run with --allow-control to change the device"
