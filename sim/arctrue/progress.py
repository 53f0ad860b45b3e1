"""How a long piece of work says what it is doing; who shows it is the caller's choice."""

from __future__ import annotations

from collections.abc import Callable

Say = Callable[[str], None]
"""Gets one line for people whenever another step begins."""
