"""Defines a proof of ``make formal`` and the faults that it must notice."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Break:
    """Fault in the VHDL: ``old``, which occurs exactly once in ``entity``, is replaced by
    ``new``."""

    name: str
    old: str
    new: str
    entity: str = ""  # empty: the fault is in the entity of the proof
    # Clocks in which no assertion can fail yet; the search for a counterexample skips them.
    skip: int = 0


@dataclass(frozen=True)
class Proof:
    """Proof of an entity: the entity, its rules, and the faults that the proof must notice."""

    name: str
    entity: str
    claims: tuple[str, ...]
    breaks: tuple[Break, ...]
    depth: int  # length k of the induction, in clocks
    cover_depth: int  # clocks within which each cover statement must be reachable
    limits: str = ""  # assumptions of the rules beyond the protocol, for the table
    # Values of the entity's generics; the rules have parameters with the same names.
    generics: Mapping[str, int] = field(default_factory=dict)
    # Further entities that the rules connect to the proof's entity, each with the names of its
    # generics.
    further: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    # Smaller generics for the search for a counterexample, because this search goes clock by clock
    # and is slower than a proof.
    small: Mapping[str, int] = field(default_factory=dict)
    # Wires of the rules, and the signals of the entity to which they are connected.
    probes: Mapping[str, str] = field(default_factory=dict)
    # Constants of number_formats_pkg that have smaller values in the proof, so that memories are
    # smaller.
    constants: Mapping[str, int] = field(default_factory=dict)
    # Memories (patterns of names) whose words become signals, to which a probe can refer.
    words: tuple[str, ...] = ()
    # Modules (patterns of names) that are removed: their outputs may have any value.
    cut: tuple[str, ...] = ()
    # Signals (module/w:name) whose drivers are cut, so that they may have any value in any clock.
    cut_signals: tuple[str, ...] = ()
    quick: bool = True  # whether `make test` runs this proof
    # Name of the proof whose rules this proof uses; empty: this proof has its own rules.
    rules_of: str = ""

    @property
    def rules(self) -> str:
        """Return the name of the module of the rules, which is in a file of formal/ with the same
        name."""
        return f"{self.rules_of or self.name}_rules"
