"""Declares the keys of the coefficient file in its three schemas."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Literal

from msgspec import Meta, Struct

from arctrue.base.typed_content import Number
from arctrue.gateware.extension import POINT_LIMIT, PhaseSource
from arctrue.gateware.lane_words import ORDER_MAX
from arctrue.generated.number_formats import LANES_MAX, PHASE_STEP_WIDTH

SCHEMA = 1
THERMAL_SCHEMA = 2
"""Schema number of a file with lanes that follow the temperature and without an extension."""
EXTENDED_SCHEMA = 3
"""Schema number of a file with an :class:`Extension` (mean, conditions, modulators, real orders,
local table or prepared sets); without an extension, the file has schema 1 or 2."""


class OffsetKeys(Struct, forbid_unknown_fields=True):
    """The table ``[offset]``."""

    counts: Number
    word: int


class LaneKeys(Struct, forbid_unknown_fields=True):
    """A table ``[[lane]]`` of schema 1."""

    lane: Annotated[int, Meta(ge=0, lt=LANES_MAX)]
    order: Annotated[int, Meta(ge=0, le=ORDER_MAX)]
    amplitude_arcsec: Number
    phase_deg: Number
    phase_step: Annotated[int, Meta(ge=0, lt=2**PHASE_STEP_WIDTH)]
    phase_offset: int
    amplitude: int


class ThermalLaneKeys(LaneKeys, forbid_unknown_fields=True):
    """A table ``[[lane]]`` of schema 2, with a slope if the lane follows the temperature."""

    slope_arcsec_per_k: tuple[Number, Number] | None = None
    slope_arcsec_per_k2: tuple[Number, Number] | None = None
    slope: tuple[int, int, int, int] | None = None

    def __post_init__(self) -> None:
        """Raise ValueError for a slope without all of its keys."""
        found = {name: getattr(self, name) for name in _SLOPE_KEYS}
        lacking = [name for name, value in found.items() if value is None]
        if 0 < len(lacking) < len(found):
            raise ValueError(f"{lacking[0]}: is missing: a slope has {', '.join(_SLOPE_KEYS)}")


_SLOPE_KEYS = ("slope_arcsec_per_k", "slope_arcsec_per_k2", "slope")


class TemperatureKeys(Struct, forbid_unknown_fields=True):
    """The table ``[temperature]``."""

    reference_c: Number
    sensor_time_constant_s: Number
    least_c: Number = math.nan
    most_c: Number = math.nan


class FileKeys(Struct, forbid_unknown_fields=True, kw_only=True):
    """A file of schema 1."""

    schema: Literal[1]
    counts_per_rev: int
    lanes: Annotated[int, Meta(ge=1, le=LANES_MAX)]
    offset: OffsetKeys
    title: str = ""
    lane: list[LaneKeys] = []


class ThermalFileKeys(FileKeys, forbid_unknown_fields=True, kw_only=True):
    """A file of schema 2."""

    schema: Literal[2]  # type: ignore[assignment]
    temperature: TemperatureKeys
    lane: list[ThermalLaneKeys] = []  # type: ignore[assignment]


class ExtendedLaneKeys(ThermalLaneKeys, forbid_unknown_fields=True, kw_only=True):
    """A table ``[[lane]]`` of schema 3."""

    order: Annotated[float, Meta(ge=0, le=ORDER_MAX)]  # type: ignore[assignment]
    turn_step: Annotated[int, Meta(ge=0, lt=2**PHASE_STEP_WIDTH)] = 0
    modulator: str = "one"
    phase_from: str = "operator"
    probe_side: int = 0
    probe_phase: int = 0

    @property
    def phase_source(self) -> PhaseSource | None:
        """Return the origin of the lane's phase; None: the operator states the phase."""
        if self.phase_from == "operator" and not (self.probe_side or self.probe_phase):
            return None
        return PhaseSource(self.phase_from, self.probe_side, self.probe_phase)


class MeanHeadKeys(Struct, forbid_unknown_fields=True):
    """A table ``[[mean.head]]``: weight and offset of a head."""

    weight: Number
    weight_word: int
    offset_counts: Number
    offset_word: int
    delay_clocks: int = 0


class MeanKeys(Struct, forbid_unknown_fields=True):
    """The table ``[mean]``."""

    carrier: int
    head: list[MeanHeadKeys]


class ConditionsKeys(Struct, forbid_unknown_fields=True):
    """The table ``[conditions]``."""

    width_counts: Number
    dead_zone_counts: int
    nominal_deg_per_s: Number


class LocalTableKeys(Struct, forbid_unknown_fields=True):
    """The table ``[local_table]``."""

    width_turn: Number
    fraction_bits: int
    starts_counts: list[int]
    points: list[Annotated[int, Meta(ge=-POINT_LIMIT, lt=POINT_LIMIT)]]


class WithoutKeys(Struct, forbid_unknown_fields=True):
    """A table ``[[without]]``: the prepared set for a missing head."""

    head: int
    carrier: int
    weight_words: list[int]
    offset_words: list[int]
    offset_word: int
    lane: list[ExtendedLaneKeys] = []


class ExtendedFileKeys(FileKeys, forbid_unknown_fields=True, kw_only=True):
    """A file of schema 3."""

    schema: Literal[3]  # type: ignore[assignment]
    temperature: TemperatureKeys | None = None
    lane: list[ExtendedLaneKeys] = []  # type: ignore[assignment]
    mean: MeanKeys | None = None
    conditions: ConditionsKeys | None = None
    local_table: LocalTableKeys | None = None
    without: list[WithoutKeys] = []


class OnlySchema(Struct):
    """The schema number of a file; the other keys are not checked."""

    schema: Literal[1, 2, 3]


DECLARED: Mapping[int, type[FileKeys]] = {
    SCHEMA: FileKeys,
    THERMAL_SCHEMA: ThermalFileKeys,
    EXTENDED_SCHEMA: ExtendedFileKeys,
}
