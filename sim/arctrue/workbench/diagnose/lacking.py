"""States in words the data that a set lacks, and the measurement that would supply them.

A mount, a robot or a rotary stage of another maker has one reading only. Its owner can measure more
of the same kind, but cannot record a capture of two heads.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence

from arctrue.workbench.effects.missing import CAPTURE, Lack, missing_of


def lacking_words(items: Sequence[str]) -> list[str]:
    """Return the lacking data, each once and sorted; an entry with a reason replaces the entry
    without it."""
    every = [missing_of(item) for item in sorted(set(items))]
    with_reason = {item.what for item in every if item != item.what}
    return [item for item in every if item not in with_reason]


def of_the_same_kind(untestable: Mapping[str, Sequence[str]]) -> str:
    """Return the next measurement for a set that has only a reference: data that this reading can
    supply, and the number of effects that a capture of two heads could test in addition.

    A key is not a measurement and is listed last.
    """
    possible = {name: items for name, items in untestable.items() if not _needs_capture(items)}
    lacking = Counter(what for items in possible.values() for what in items)
    if lacking:
        order = sorted(lacking, key=lambda what: (_is_key(what), -lacking[what], what))
        number = f"{len(possible)} of the effects that were not tested"
        need = "each need one or more of these" if len(order) > 1 else "need it"
        need = need if len(possible) > 1 else "needs it" if len(order) == 1 else "needs them"
        words = f"a set that has {'; '.join(order)}: {number} {need}"
    else:
        words = (
            "the same reference run with more turns, at another speed, or while one condition "
            "changes (temperature, load): an error that depends on this change changes too"
        )
    return words + _of_two_heads(len(untestable) - len(possible))


def separates(name: str, look_alikes: Mapping[str, Sequence[str]], own: str) -> str:
    """Return the next measurement for a set that has only a reference and cannot separate an effect
    from ``look_alikes``.

    ``own``: the measurement that the effect itself declares; it is stated if every look-alike needs
    a capture.
    """
    possible = {other: items for other, items in look_alikes.items() if not _needs_capture(items)}
    words = own
    if possible:
        lacking = lacking_words([what for items in possible.values() for what in items])
        words = (
            f"a set that has {'; '.join(lacking)}: it separates {name} from {', '.join(possible)}"
        )
    return words + _of_two_heads(len(look_alikes) - len(possible))


def _needs_capture(items: Sequence[str]) -> bool:
    return any(missing_of(item).kind is Lack.CAPTURE for item in items)


def _is_key(item: str) -> bool:
    return missing_of(item).kind is Lack.KEY


def _of_two_heads(effects: int) -> str:
    if not effects:
        return ""
    return f" (on a table with two heads, {CAPTURE} could test {effects} more)"
