"""Defines the errors of the instrument; the user reads their messages."""

from __future__ import annotations


class InstrumentError(RuntimeError):
    """Is raised if a tool is missing, a build fails, or the instrument cannot fulfil a request."""


class BusError(InstrumentError):
    """Is raised if the core answers a bus access with an error."""

    def __init__(self, address: int, response: int) -> None:
        """Store the byte ``address`` and ``response``, the two bits of the AXI4-Lite answer."""
        super().__init__(
            f"the core answered the access at 0x{address:05X} with response {response} "
            f"(2 is SLVERR: the register map does not allow it)"
        )
        self.address = address
        self.response = response
