"""Models the entity ``head_failover``, which selects the prepared set of coefficients that is
loaded, and the heads that are left out of the mean."""

from __future__ import annotations

from dataclasses import dataclass

from arctrue.generated.number_formats import (
    FAILOVER_REARM_CLOCKS,
    OWN_WORDS_SET,
    WATCH_INTERVAL_BITS,
)


@dataclass(frozen=True)
class FailoverInputs:
    """Inputs of the entity in one clock; an input that names heads is a number with one bit per
    head, head 1 in the lowest bit."""

    failed: int = 0
    causes: int = 0
    used: int = 0
    idle_used: int = 0
    idle_carrier_used: bool = True
    indices_seen: int = 0
    swap_comes: bool = False
    busy: bool = False
    loaded: bool = False
    refused: bool = False
    clear: bool = False
    take_set: int | None = None
    """Number of the prepared set that ``heads_command`` requests."""
    come_back: int = 0


@dataclass
class HeadFailover:
    """Registers of the entity with ``failover.enable`` set; one call of ``clock`` is one clock.

    A head remains left out until a prepared set is loaded in which it is not the missing head, or
    until it returns. It returns if it has found its index again and one of two further conditions
    is true: the processor has requested its return, or the time ``return_after`` (not 0, in units
    of 2^(``interval_bits`` + 3) clocks) has passed. The entity then loads set 0, but loads no set
    while the coefficients that the processor wrote are active. If the core refuses the set of a
    failed head, the entity does not load this set for a failure again before the next swap or a
    write of the register ``failover``; the model omits the write.
    """

    heads: int
    return_after: int = 0
    interval_bits: int = WATCH_INTERVAL_BITS
    load: bool = False
    number: int = 0
    left_out: int = 0
    set_in_force: int = OWN_WORDS_SET
    may_activate: bool = False
    changed: bool = False
    swap_refused: bool = False
    watching: bool = False
    _set_refused: bool = False
    _has_no_set: int = 0
    _wanted: int | None = None
    _wants_return: int = 0
    _waited: int = 0
    _tick: int = 0
    _rearming: int = 0

    @property
    def rearm_heads(self) -> int:
        """Return the heads whose index is being cleared."""
        return self.left_out if self._rearming else 0

    def _barred(self, busy: bool) -> int:
        """Return the heads that the coefficients and weights in the idle bank may not use."""
        if busy:
            return 1 << self.number >> 1
        return self.left_out

    def clock(self, now: FailoverInputs) -> None:
        """Advance by one clock."""
        barred = self._barred(now.busy)
        needs_carrier = now.busy or self.left_out != 0
        has_index = self._rearming == 0 and not self.left_out & ~now.indices_seen
        waited = self._waited
        returns = bool(
            self.left_out
            and has_index
            and (
                self._wants_return & self.left_out
                or (self.return_after and waited >= self.return_after)
            )
        )
        all_used = now.used == (1 << self.heads) - 1
        old_left_out, old_rearming, free = (
            self.left_out,
            self._rearming,
            not (now.busy or self.load),
        )
        watching = all_used and not self.left_out and free and self._wanted is None
        tick_full = self._tick == (1 << (self.interval_bits + 3)) - 1
        self._tick = (self._tick + 1) % (1 << (self.interval_bits + 3))
        self._waited = min(waited + tick_full, (1 << 16) - 1)
        self._rearming = max(old_rearming - 1, 0)
        self.swap_refused = (
            (self.swap_refused and not now.clear) or now.refused or self._set_refused
        )
        self.load = self.changed = self._set_refused = False
        number = self.number
        leaving = now.failed & ~self._has_no_set
        if now.refused and now.busy:
            self._has_no_set |= 1 << self.number >> 1
        if now.swap_comes:
            self._has_no_set = 0
        if free:
            if self._wanted is not None:
                if old_left_out & ~(1 << self._wanted >> 1) and not has_index:
                    self._set_refused = True
                else:
                    self.load, number = True, self._wanted
                self._wanted = None
            elif leaving and self.watching:
                self.load = True
                number = (leaving & -leaving).bit_length()
            elif returns and self.set_in_force != OWN_WORDS_SET:
                self.load, number = True, 0
            elif returns:
                self.left_out, self._wants_return, self.changed = 0, 0, True
        if now.loaded:
            self.set_in_force, self.changed = self.number, True
            self._waited = self._tick = self._wants_return = 0
            self._rearming = FAILOVER_REARM_CLOCKS
            self.left_out = 1 << self.number >> 1
        elif now.swap_comes:
            self.set_in_force = OWN_WORDS_SET
        self._wants_return |= now.come_back
        if now.take_set is not None and now.take_set <= self.heads:
            self._wanted = now.take_set
        self.may_activate = not now.idle_used & barred and (
            now.idle_carrier_used or not needs_carrier
        )
        self.number, self.watching = number, watching
