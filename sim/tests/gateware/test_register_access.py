"""Tests that an error for an unknown register or field names it, and lists existing names."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence

import pytest

from arctrue.gateware.register_access import RegisterMap, register_named


async def _no_read(address: int, count: int) -> Sequence[int]:
    raise AssertionError("nothing may be read for a name that is not in the map")


async def _no_write(address: int, words: Sequence[int]) -> None:
    raise AssertionError("nothing may be written for a name that is not in the map")


@pytest.mark.parametrize(
    ("path", "near"),
    [("velocity", "identification"), ("head1.speed", "head1.flags"), ("flag", "head2.flags")],
)
def test_an_unknown_register_is_named_whole(path: str, near: str) -> None:
    registers = RegisterMap(_no_read, _no_write)
    for access in (registers.read(path), registers.write(path, 0), registers.read_fields(path)):
        with pytest.raises(KeyError) as raised:
            asyncio.run(access)
        assert f"no register {path!r}" in str(raised.value.args[0])
        assert near in str(raised.value.args[0])


def test_an_unknown_field_is_reported_with_those_there_are() -> None:
    with pytest.raises(KeyError, match=r"head1\.flags has no field speed; it has: .*index_error"):
        register_named("head1.flags").field("speed")
