"""Simulates a master that sends AXI3 bursts, with IDs, from M_AXI_GP0 of the PS7 model."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from cocotb.triggers import FallingEdge

INCR = 1
OKAY = 0
BEATS = 16
PAGE_BYTES = 4096
LONGEST_WAIT = 4000  # clocks; a beat takes about 4, the core answers within 10


class BusError(Exception):
    """Raised if the answer to a beat that is read, or to a burst that is written, is not OKAY."""


def bursts(address: int, words: int) -> Iterator[tuple[int, int]]:
    """Yield address and number of beats of the bursts for ``words`` words; no burst crosses a
    boundary of 4 KiB."""
    while words:
        beats = min(words, BEATS, (PAGE_BYTES - address % PAGE_BYTES) // 4)
        yield address, beats
        address += 4 * beats
        words -= beats


class Axi3Master:
    """Sends one burst at a time in each direction; every answer must have the ID of its burst.

    The fabric changes its signals only at a rising edge, so the next rising edge samples the levels
    that the master reads at the falling edge in between.
    """

    def __init__(self, ps7: Any) -> None:
        """Connect to ``ps7``, the instance of the PS7 model."""
        self.ps7 = ps7
        self.identity = 0x5A5

    def _next_identity(self) -> int:
        self.identity = (self.identity * 5 + 0x123) % 4096
        return self.identity

    def _port(self, name: str) -> int:
        return int(getattr(self.ps7, f"maxigp0{name}").value)

    async def _falling(self) -> None:
        await FallingEdge(self.ps7.fabric_clock)

    async def _give(self, channel: str, **payload: int) -> None:
        """Drive a payload on a channel until the fabric has accepted it."""
        for name, value in payload.items():
            getattr(self.ps7, f"master_{channel}{name}").value = value
        valid = getattr(self.ps7, f"master_{channel}valid")
        valid.value = 1
        for _ in range(LONGEST_WAIT):
            taken = self._port(f"{channel}ready")
            await self._falling()
            if taken:
                valid.value = 0
                return
        raise AssertionError(f"{channel} was not taken in {LONGEST_WAIT} clocks")

    async def _take(self, channel: str, *names: str) -> list[int]:
        """Wait for a payload on a channel and accept it; return its fields."""
        ready = getattr(self.ps7, f"master_{channel}ready")
        ready.value = 1
        for _ in range(LONGEST_WAIT):
            if self._port(f"{channel}valid"):
                payload = [self._port(channel + name) for name in names]
                await self._falling()
                ready.value = 0
                return payload
            await self._falling()
        raise AssertionError(f"nothing came on {channel} in {LONGEST_WAIT} clocks")

    async def write_burst(self, address: int, words: Sequence[int]) -> int:
        """Write one INCR burst of whole words; return the answer to the burst."""
        identity = self._next_identity()
        await self._falling()
        await self._give("aw", addr=address, id=identity, len=len(words) - 1, size=2, burst=INCR)
        for place, word in enumerate(words):
            await self._give("w", data=word, strb=0xF, last=int(place == len(words) - 1))
        answered, answer = await self._take("b", "id", "resp")
        assert answered == identity, f"the answer has ID {answered:#x}, the burst {identity:#x}"
        return answer

    async def read_burst(self, address: int, beats: int) -> list[tuple[int, int]]:
        """Read one INCR burst of whole words; return data and answer of every beat."""
        identity = self._next_identity()
        await self._falling()
        await self._give("ar", addr=address, id=identity, len=beats - 1, size=2, burst=INCR)
        found = []
        for place in range(beats):
            answered, answer, data, last = await self._take("r", "id", "resp", "data", "last")
            assert answered == identity, f"a beat has ID {answered:#x}, its burst {identity:#x}"
            assert last == int(place == beats - 1), f"RLAST is {last} at beat {place} of {beats}"
            found.append((data, answer))
        return found

    async def read_words(self, address: int, count: int) -> list[int]:
        """Return ``count`` words, read in the longest possible bursts; raise BusError if an answer
        is not OKAY."""
        words = []
        for first, beats in bursts(address, count):
            for place, (data, answer) in enumerate(await self.read_burst(first, beats)):
                if answer != OKAY:
                    raise BusError(f"read at 0x{first + 4 * place:08X}: answer {answer}")
                words.append(data)
        return words

    async def write_words(self, address: int, words: Sequence[int]) -> None:
        """Write words in the longest possible bursts; raise BusError if an answer is not OKAY."""
        done = 0
        for first, beats in bursts(address, len(words)):
            answer = await self.write_burst(first, words[done : done + beats])
            if answer != OKAY:
                raise BusError(f"write of {beats} words at 0x{first:08X}: answer {answer}")
            done += beats
