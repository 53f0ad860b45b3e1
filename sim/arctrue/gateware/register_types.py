"""Defines the types with which the generated description of the register map is written."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Field:
    """A field: some bits of a register.

    ``reset`` is the value after reset, None if the gateware drives the field; ``constant``: the
    field never changes.
    """

    name: str
    shift: int
    width: int
    signed: bool = False
    write_one_to_clear: bool = False
    reset: int | None = None
    constant: bool = False

    @property
    def mask(self) -> int:
        """Return a register word in which the bits of the field are 1 and all others 0."""
        return ((1 << self.width) - 1) << self.shift

    def get(self, word: int) -> int:
        """Return the value of the field in ``word``, the content of its register."""
        value = (word & self.mask) >> self.shift
        if self.signed and value >> (self.width - 1):
            value -= 1 << self.width
        return value

    def put(self, value: int) -> int:
        """Return a register word with ``value`` in the field and 0 in all other bits.

        Raises ValueError for a value that the field cannot hold.
        """
        low = -(1 << (self.width - 1)) if self.signed else 0
        high = (1 << (self.width - 1 if self.signed else self.width)) - 1
        if not low <= value <= high:
            raise ValueError(f"field {self.name}: expected {low} to {high}, found {value}")
        return (value << self.shift) & self.mask


@dataclass(frozen=True, slots=True)
class Register:
    """A register of 32 or 64 bits; a latched register keeps its value until another register, its
    trigger, is read."""

    path: str
    address: int
    width: int
    readable: bool
    writable: bool
    latched: bool
    fields: tuple[Field, ...]

    @property
    def words(self) -> int:
        """Return the number of 32-bit words of the register; the low word is the first."""
        return self.width // 32

    def field(self, name: str) -> Field:
        """Return the field with this name. Raises KeyError, which lists the existing names."""
        for field in self.fields:
            if field.name == name:
                return field
        known = ", ".join(field.name for field in self.fields)
        raise KeyError(f"register {self.path} has no field {name}; it has: {known}")


@dataclass(frozen=True, slots=True)
class Memory:
    """A window: consecutive 32-bit words."""

    path: str
    address: int
    words: int
    readable: bool
    writable: bool
