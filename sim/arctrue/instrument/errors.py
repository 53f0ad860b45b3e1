"""Defines the errors of the instrument, with messages for people."""

from __future__ import annotations


class InstrumentError(RuntimeError):
    """A tool is missing, a build failed, or a request to the instrument cannot be fulfilled."""


class BusError(InstrumentError):
    """The core answered an access with an error."""

    def __init__(self, address: int, response: int) -> None:
        """Store address and answer: ``address`` in bytes; ``response`` is the two bits of the
        AXI4-Lite answer."""
        super().__init__(
            f"the core answered the access at 0x{address:05X} with response {response} "
            f"(2 is SLVERR: the register map does not allow it)"
        )
        self.address = address
        self.response = response
