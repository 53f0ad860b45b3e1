"""Defines rows with the conditions and the measured value, from which effects compute their
design-matrix columns."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from arctrue.base.units import ARCSEC_PER_RAD
from arctrue.workbench.observations.contrasts import contrast_weights
from arctrue.workbench.observations.head_noise import HeadNoise

Float = NDArray[np.float64]
Integer = NDArray[np.int64]


class _Sliceable:
    """Base class of rows; its method ``part`` returns a subset of the rows of every column."""

    __slots__ = ()

    def __post_init__(self) -> None:
        """Make every array, also those in ``conditions``, a read-only view, so that no effect can
        change the rows to which other effects are fitted."""
        for item in fields(self):  # type: ignore[arg-type]
            value = getattr(self, item.name)
            if isinstance(value, np.ndarray):
                object.__setattr__(self, item.name, _read_only(value))
            elif isinstance(value, Mapping):
                columns = {name: _read_only(column) for name, column in value.items()}
                object.__setattr__(self, item.name, columns)

    def part(self, rows: slice | NDArray[np.bool_] | Integer) -> Self:
        """Return the object with only the given rows.

        Parameters
        ----------
        rows : slice or ndarray, shape (n,)
            The rows: their indices, or one Boolean value per row.

        Returns
        -------
        CaptureRows or ReferenceRows
            The same kind of rows.
        """
        values = {}
        for item in fields(self):  # type: ignore[arg-type]
            value = getattr(self, item.name)
            if isinstance(value, np.ndarray):
                value = value[rows]
            elif isinstance(value, Mapping):
                value = {name: column[rows] for name, column in value.items()}
            values[item.name] = value
        return type(self)(**values)


def _read_only(values: NDArray[Any]) -> NDArray[Any]:
    view = values.view()
    view.setflags(write=False)
    return view


@dataclass(frozen=True, eq=False)
class CaptureRows(_Sliceable):
    """One row per sample of two heads; arrays have shape (rows,) unless another shape is stated.

    With three or four heads each sample has one row for each head after head 1, and the rows of one
    such head form a channel. Channel 0 is R₂ − R₁. Channel k is the reading of head k + 2 minus the
    mean of all heads before it, weighted and scaled by their noise
    (:mod:`arctrue.workbench.observations.contrasts`). Each channel of a run counts as a run.
    """

    run: Integer
    """Number of the run, 0 … runs − 1, in the order of the file; with K channels: recorded run · K
    + channel."""
    revolution: Integer
    """Number of the revolution, counted over all runs; an unfinished revolution has a number of its
    own. With K channels: recorded revolution · K + channel."""
    time_s: Float
    """Time of the sample, seconds."""
    temperature_c: Float | None
    """Temperature of the table, °C; None if the file has none."""
    direction: Float
    """Direction of the run, +1 or −1."""
    speed_rad_s: Float
    """Signed speed: the mean speed of the run if it turns evenly or has few rows, otherwise the
    local speed, which is calculated from the rows around each row.
    """
    angle_rad: Float
    """Estimate of the true angle θ of the table, unwrapped."""
    disc1_rad: Float
    """Disc angle under head 1: θ."""
    disc2_rad: Float
    """Disc angle under head 2 (or :attr:`head`): θ + α."""
    line1_rad: Float
    """Disc angle of the lines that head 1 sees: its reading. It differs from θ by ε."""
    line2_rad: Float
    """Disc angle of the lines that head 2 (or :attr:`head`) sees: its reading."""
    electrical1_rad: Float | None
    """Phase of the signal period of head 1, 2π·frac(counts·lines/counts_per_rev)."""
    electrical2_rad: Float | None
    """Phase of the signal period of head 2 (or :attr:`head`), radians."""
    run_start_s: Float
    """Time of the first sample of the row's run, seconds."""
    set_start_s: float
    """Time of the first sample of the set, seconds."""
    session_start_s: float
    """First time of both channels, on the clock of this channel, seconds."""
    runs: int
    """Number of runs; each channel of a recorded run counts as one run."""
    head_separation_rad: float
    """Nominal angle from head 1 to head 2 (or :attr:`head`), radians."""
    reference_temperature_c: float
    """T₀ of the temperature effects: T₀ of the model, or the median temperature of the whole
    set."""
    difference_arcsec: Float
    """R₂ − R₁ − α with the nominal α, or the contrast of the row's channel."""
    u_arcsec: Float | None = None
    """Standard uncertainty of R₂ − R₁, if the file gives one for each row."""
    conditions: Mapping[str, Float] = field(default_factory=dict)
    """Further columns of the file by name, in their own units."""
    reference_in_time: bool = False
    """True if the set has a reference whose rows have a time."""
    channel: Integer | None = None
    """Number of the channel, 0 … heads − 2; None with two heads, and in the rows of
    :meth:`of_head`."""
    further_places_rad: tuple[float, ...] = ()
    """Angles of heads 3 and 4 relative to head 1."""
    further_line_rad: Float | None = None
    """Readings of heads 3 and 4, shape (rows, heads − 2)."""
    further_electrical_rad: Float | None = None
    """Phases of the signal periods of heads 3 and 4, shape (rows, heads − 2)."""
    head: int = 2
    """Number of the head i in Rᵢ − R₁; an effect computes its columns for this head."""
    head_noise: HeadNoise | None = None
    """Noise of three or four heads, which gives the weights of the contrasts; None: equal noise."""

    @property
    def measured_arcsec(self) -> Float:
        """Measured values that a model predicts: R₂ − R₁ − α, or the contrast of the row's
        channel."""
        return self.difference_arcsec

    @property
    def heads(self) -> int:
        """Number of heads of the capture."""
        return 2 + len(self.further_places_rad)

    @property
    def channels(self) -> int:
        """Number of rows per sample."""
        return 1 if self.channel is None else self.heads - 1

    @property
    def weights(self) -> Float:
        """Weights of the differences Rᵢ − R₁ in each channel, (heads − 1, heads − 1)."""
        noise = self.head_noise
        return contrast_weights(self.heads) if noise is None else noise.weights

    @property
    def offset_weights(self) -> Float | None:
        """Weights of the offsets of a run's channels in each channel, (channels, channels); None if
        each channel has its own offset only."""
        if self.head_noise is None or self.channel is None:
            return None
        return self.head_noise.offset_weights

    def offsets_of_rows(self, offsets: Float) -> Float:
        """Return the sum that the offsets of the runs add to each row.

        Parameters
        ----------
        offsets : ndarray, shape (runs,)
            Offset of each run; each channel of a recorded run counts as a run.

        Returns
        -------
        ndarray, shape (rows,)
            The sum of the offsets of the row's recorded run, in the weights of its channel.
        """
        weights = self.offset_weights
        if weights is not None:
            mixed = offsets.reshape(-1, self.channels) @ weights.T
            offsets = mixed.reshape(-1)
        return offsets[self.run]

    def run_words(self, run: int) -> str:
        """Name a run as it was recorded: ``run 3``, or ``run 1 head 4``.

        Parameters
        ----------
        run : int
            Number of the run in these rows.

        Returns
        -------
        str
            The recorded run, and the head of its channel if a sample has more than one row.
        """
        if self.channel is None:
            return f"run {run}"
        return f"run {run // self.channels} head {run % self.channels + 2}"

    def of_head(self, head: int) -> CaptureRows:
        """Return the samples as rows of Rᵢ − R₁, from which an effect computes columns of head i.

        Parameters
        ----------
        head : int
            Number of the head, 2 to ``heads``.

        Returns
        -------
        CaptureRows
            Rows whose ``head`` is ``head``; ``channel`` is None.

        Raises
        ------
        ValueError
            These rows already belong to another head.
        """
        if self.channel is None:
            if head == self.head:
                return self
            raise ValueError(f"these rows are of head {self.head}, not of head {head}")
        return self._asked_of(head)

    def as_recorded(self, head: int) -> CaptureRows:
        """Return these rows, all of channel 0, as if the capture had only head 1 and this head.

        Parameters
        ----------
        head : int
            Number of the head, 2 to ``heads``.

        Returns
        -------
        CaptureRows
            Rows with the recorded numbers of runs and revolutions, and Rᵢ − R₁ minus the nominal
            angle from head 1 to head i.
        """
        assert self.channel is not None
        channels, rows = self.channels, self.of_head(head)
        apart = rows.line2_rad - rows.line1_rad - rows.head_separation_rad
        return replace(
            rows,
            run=self.run // channels,
            revolution=self.revolution // channels,
            runs=self.runs // channels,
            difference_arcsec=apart * ARCSEC_PER_RAD,
            head_noise=None,
            further_places_rad=(),
            further_line_rad=None,
            further_electrical_rad=None,
        )

    def _asked_of(self, head: int) -> CaptureRows:
        assert self.channel is not None
        run = self.run - self.channel + (head - 2)
        if head == 2:
            return replace(self, run=run, channel=None)
        assert self.further_line_rad is not None
        place_rad, electrical = self.further_places_rad[head - 3], self.further_electrical_rad
        return replace(
            self,
            run=run,
            channel=None,
            head=head,
            disc2_rad=self.disc1_rad + place_rad,
            line2_rad=self.further_line_rad[:, head - 3],
            electrical2_rad=None if electrical is None else electrical[:, head - 3],
            head_separation_rad=place_rad,
        )


@dataclass(frozen=True, eq=False)
class ReferenceRows(_Sliceable):
    """One row per comparison of head 1 with the reference; every array has shape (rows,)."""

    run: Integer
    """Number of the run as in the file; 0 if the file has none."""
    cycle: Integer | None
    """Number of the cycle; None if the file has none."""
    time_s: Float | None
    """Time of the reading, seconds; None if the file has none."""
    temperature_c: Float | None
    """Temperature of the table, °C; None if the file has none."""
    direction: Float | None
    """Direction in which the table approached the station, +1 or −1; None if the file does not
    state it."""
    target_rad: Float
    """Angle to which the table was driven, unwrapped as in the file; it is the same at each
    visit."""
    angle_rad: Float
    """True angle θ of the table at the station: the reading minus the measured error, because the
    servo brings the reading, not θ, to the target. If the readings are not known, it is the target.
    """
    line_rad: Float
    """Disc angle of the lines under head 1 at the station: its reading; ``angle_rad`` if the set
    has no capture.
    """
    face: Integer | None
    """Number of the polygon face, 0 … faces − 1; between two faces, the number of the nearest
    face."""
    faces: int | None
    """Number of faces of the polygon; None if the reference is not a polygon."""
    electrical1_rad: Float | None
    """Phase of the signal period of head 1, radians; None if lines or counts are not known."""
    teeth: float | None
    """Number of teeth of the gear that drives the table (drive_gear_teeth); None if not stated."""
    speed_rad_s: Float | None
    """Signed speed of the table while the reference was read; None if the table stood still or its
    speed is not known."""
    run_start_s: Float | None
    """Time of the first reading of the row's run, seconds; None if the file has no time."""
    set_start_s: float
    """Time of the first row of the reference, seconds; 0 without times."""
    session_start_s: float
    """First time of both channels, on the clock of this channel, seconds; 0 without times."""
    middle_time_s: float
    """Middle between the first and the last time of the rows, seconds; 0 without times."""
    reference_temperature_c: float
    """T₀ of the temperature effects, °C."""
    error_arcsec: Float
    """ε: reading of head 1 minus the angle of the reference; the mean over all rows is
    subtracted."""
    u_arcsec: Float | None = None
    """Standard uncertainty of ε, if the file gives one for each row."""
    reversals: Integer | None = None
    """Number of reversals of the direction in the rows before; None without directions."""
    travel_rad: Float | None = None
    """Travel of the targets since the last reversal, or since the first row; None without
    directions."""
    at_reversal: NDArray[np.bool_] | None = None
    """True if the row's travel is less than that to the second place after every reversal; None
    without directions."""
    row: Integer | None = None
    """Number of the row among all used rows; None if the rows are 0, 1, … without a gap."""
    capture_runs: int | None = None
    """Number of runs of the capture of the same set, 0 without a capture; None if these rows do not
    belong to a set.
    """
    heads: int = 2
    """Number of heads of the set's capture."""
    conditions: Mapping[str, Float] = field(default_factory=dict)
    """Further columns of the file by name, in their own units."""

    @property
    def measured_arcsec(self) -> Float:
        """Measured values that a model predicts: ε."""
        return self.error_arcsec
