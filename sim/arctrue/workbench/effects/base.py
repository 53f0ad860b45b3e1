"""What a physical effect is to the workbench: the interface of every file in this folder.

An effect turns the conditions of each measured row (angle, time, temperature, direction, ...)
into columns; the fit finds one coefficient a column, common to both channels. What an effect
needs beyond linear coefficients (an order, a frequency, an instant) it declares as search
parameters, with the kind of search that finds them.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from arctrue.base.similar import did_you_mean
from arctrue.base.units import RAD_PER_ARCSEC

if TYPE_CHECKING:
    from arctrue.workbench.observations import CaptureRows, Observations, ReferenceRows

Columns = NDArray[np.float64]
"""Shape (rows, coefficients)."""

Nonlinear = Mapping[str, float]
"""Values of the search parameters, by name."""

Compensation = Literal["lanes", "offset", "modulators", "local_table", "none", "reference"]
"""What of an effect the gateware can correct: harmonics of the angle, a constant, a shape at one
place of the turn, or nothing; an
error of the reference is none of the table's, and is taken out of every judgement of it."""


SearchKind = Literal[
    "grid", "disc_order", "unwrapped_order", "frequency", "line", "step", "disc_place"
]
"""How the inference looks for the search parameters of an effect: every point of the declared
ranges; a whole order of the disc, an order over the unwrapped angle, a frequency in time, any of
these in either channel; the instant of a step in a run; place and width of a bump on the disc."""

SEARCHED: Mapping[SearchKind, frozenset[str]] = {
    "disc_order": frozenset({"order"}),
    "unwrapped_order": frozenset({"order"}),
    "frequency": frozenset({"frequency"}),
    "line": frozenset({"order", "frequency", "in_time", "in_capture"}),
    "step": frozenset({"run", "instant"}),
    "disc_place": frozenset({"place", "width"}),
}
"""Names of the search parameters that a kind finds; a grid finds any."""


class Gain(Protocol):
    """What a block of columns takes of the residuals."""

    @property
    def gain(self) -> float:
        """2·Δ(log likelihood), the noise held."""


class Leftover(Protocol):
    """What the model leaves, as far as an effect may ask: how much of it some columns take."""

    observations: Observations

    def score(self, effect: Effect, nonlinear: Nonlinear) -> Gain:
        """Of an effect's whole block, the model projected out."""


@dataclass(frozen=True, slots=True)
class Parameter:
    """A fitted quantity as people read it: value, standard uncertainty, unit."""

    value: float
    sigma: float
    unit: str


@dataclass(frozen=True, slots=True)
class Lane:
    """A harmonic of head 1's error that a lane of the gateware can take away."""

    order: int
    cosine_arcsec: float
    sine_arcsec: float


Condition = Literal["direction", "speed", "speed_squared", "column"]
"""What the amplitude of a lane may follow (the gateware's generic MODULATORS).

``column``: a further column of the set, which the host measures and writes to a word.
"""


@dataclass(frozen=True, slots=True)
class ConditionedLane:
    """A harmonic of head 1's error, order 0 a constant, in proportion to a condition.

    Per unit of the condition: direction ±1, speed in rad/s or its square, or the column's unit.
    """

    condition: Condition
    lane: Lane
    column: str = ""
    """Name of the column where that is the condition."""
    column_zero: float = 0.0
    """Value of the column at which the condition is 0."""


@dataclass(frozen=True, slots=True)
class RealLane:
    """A line of head 1's error of no whole order, over all turns (generic REAL_ORDERS)."""

    order: float
    cosine_arcsec: float
    sine_arcsec: float


@dataclass(frozen=True, slots=True)
class LocalError:
    """An error of head 1 at one place of the turn (the gateware's generic LOCAL_TABLE)."""

    place_rad: float
    """Reading of the head at its middle."""
    half_width_rad: float
    """Farther from the middle it is negligible."""
    error_arcsec: Callable[[NDArray[np.float64]], NDArray[np.float64]]
    """Error at readings in radians, shape (n,)."""


@dataclass(frozen=True, slots=True)
class SearchParameter:
    """A parameter that enters the columns nonlinearly and is therefore searched."""

    name: str
    unit: str
    low: float
    high: float
    meaning: str
    steps: int = 64
    """Points of the grid that the default scan tries."""
    integer: bool = False
    """Only whole numbers mean something; such a parameter is not refined."""


CONTRADICTED_P = 0.005
"""Share of true effects that their own physics may refuse: half of the 1 % of false names."""


@dataclass(frozen=True)
class FitContext:
    """What the present model says, for effects whose columns depend on it.

    The error function is that of the graduation, equation (9): arcseconds as a function of the disc
    angle in radians.
    """

    cosine_arcsec: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))
    sine_arcsec: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))
    orders: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    at_angle: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, dtype=np.bool_))
    """Orders whose columns are taken at the true angle: a reading that lags is not yet in
    them. Columns at the reading have it already."""
    coefficients: Mapping[str, NDArray[np.float64]] = field(default_factory=dict)
    """What was found of the effects that depend on the model, by name."""

    def shifted_arcsec(
        self, disc_rad: NDArray[np.float64], shift_rad: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """ε(ψ + shift) − ε(ψ) in arcseconds, of the orders at the true angle; shapes (rows,)."""
        total = np.zeros_like(disc_rad, dtype=np.float64)
        for order, cosine, sine, there in zip(
            self.orders, self.cosine_arcsec, self.sine_arcsec, self.at_angle, strict=True
        ):
            if there:
                # cos(a + s) − cos a = −2 sin(a + s/2) sin(s/2), without a difference of like size.
                middle, half = order * (disc_rad + 0.5 * shift_rad), 0.5 * order * shift_rad
                total += 2.0 * np.sin(half) * (sine * np.cos(middle) - cosine * np.sin(middle))
        return total

    def error_arcsec(self, disc_rad: NDArray[np.float64]) -> NDArray[np.float64]:
        """ε(ψ) in arcseconds, shape of ``disc_rad``."""
        total = np.zeros_like(disc_rad, dtype=np.float64)
        for order, cosine, sine in zip(
            self.orders, self.cosine_arcsec, self.sine_arcsec, strict=True
        ):
            phase = order * disc_rad
            total += cosine * np.cos(phase) + sine * np.sin(phase)
        return total

    def error_slope(self, disc_rad: NDArray[np.float64]) -> NDArray[np.float64]:
        """dε/dψ, arcsecond an arcsecond, shape of ``disc_rad``."""
        total = np.zeros_like(disc_rad, dtype=np.float64)
        for order, cosine, sine in zip(
            self.orders, self.cosine_arcsec, self.sine_arcsec, strict=True
        ):
            phase = order * disc_rad
            total += order * (sine * np.cos(phase) - cosine * np.sin(phase))
        return total * RAD_PER_ARCSEC


class Effect(ABC):
    """One physical effect. A subclass is one file; the built-in ones use just this interface."""

    name: ClassVar[str]
    """Public name: command line, model files, JSON."""
    physics: ClassVar[str]
    """What happens, in two sentences."""
    equation: ClassVar[str]
    source: ClassVar[str]
    capture_sees: ClassVar[str]
    """What the difference of the two heads shows of it."""
    reference_sees: ClassVar[str]
    """What a reference run shows of it."""
    told_apart_by: ClassVar[str]
    next_measurement: ClassVar[str]
    """The measurement that would show this effect best, or split it from its like."""
    plausible: ClassVar[str]
    """Sizes that have been seen."""
    compensation: ClassVar[Compensation] = "none"
    compensation_note: ClassVar[str] = ""
    search: ClassVar[tuple[SearchParameter, ...]] = ()
    search_kind: ClassVar[SearchKind] = "grid"
    defaults: ClassVar[Mapping[str, object]] = {}
    """Settings and their default values."""
    parameter_units: ClassVar[Mapping[str, str]] = {}
    """The main parameters that :meth:`parameters` gives, with their units."""
    depends_on_model: ClassVar[bool] = False
    """The columns depend on the fitted error function, so that the fit iterates."""
    at_reading: ClassVar[bool] = False
    """Its disc orders are taken at the reading of a head, not at the true angle."""
    step_at: ClassVar[tuple[str, str] | None] = None
    """Search parameters (run, instant) at which the only column steps from 0 to 1."""
    longest_call_s: ClassVar[float] = 60.0
    """Seconds that one call of a method of a user's file may take; ended then, as an error."""
    needs_settings: ClassVar[bool] = False
    """True: it is nothing without its settings, and the diagnosis does not try it."""
    unspecific: ClassVar[bool] = False
    """It says what is seen and not why: an effect that says more, and fits as well, is named."""
    in_parts: ClassVar[tuple[str, ...]] = ()
    """The product of parts that it is by its definition, on every set; empty: there is none."""
    local_on_disc: ClassVar[bool] = False
    """It acts on a short arc of the disc, which every turn has to show."""
    multiples_setting: ClassVar[str | None] = None
    """Setting that lists multiples of :meth:`declared_order`."""
    moves_axis: ClassVar[bool] = False
    """It shifts the axis against the heads: their weighted mean does not see it."""
    fixed_to_polygon: ClassVar[bool] = False
    """It moves along when the polygon is put on the table some faces further."""

    def __init__(self, **settings: object) -> None:
        """Raises ValueError for a setting that this effect does not have, or of a wrong type."""
        unknown = sorted(set(settings) - set(self.defaults))
        if unknown:
            known = ", ".join(sorted(self.defaults)) or "none"
            raise ValueError(
                f"effect {self.name}: unknown setting {', '.join(unknown)}."
                f"{did_you_mean(unknown[0], self.defaults)} It has: {known}"
            )
        for key, value in settings.items():
            expected = self.defaults[key]
            numbers = (int, float)
            same = isinstance(value, type(expected)) or (
                isinstance(expected, numbers) and isinstance(value, numbers)
            )
            if not same or (isinstance(value, bool) and not isinstance(expected, bool)):
                raise ValueError(
                    f"effect {self.name}: setting {key} must be like {expected!r}, found {value!r}"
                )
        self.settings: dict[str, object] = {**self.defaults, **settings}

    def integers(self, key: str) -> tuple[int, ...]:
        """A setting that lists whole numbers. Raises ValueError when it does not."""
        values = self.settings[key]
        if not isinstance(values, Sequence) or not all(
            isinstance(value, int) and not isinstance(value, bool) and value > 0 for value in values
        ):
            raise ValueError(
                f"effect {self.name}: setting {key} must list whole numbers above 0, "
                f"found {values!r}"
            )
        return tuple(values)

    def declared_order(self, observations: Observations) -> float | None:
        """Order of which it is multiples, where the set states it, as a tooth count does."""
        return None

    def disc_orders(self, nonlinear: Nonlinear) -> Sequence[int]:
        """Orders of ε(ψ) whose cos, sin coefficients this effect's first columns are."""
        return ()

    def electrical_order(self, observations: Observations) -> float:
        """Highest order of the angle that columns at the phase of a reading follow; 0: none.

        The noise of the reading is in such columns, times this order.
        """
        return 0.0

    def lanes(
        self,
        coefficients: NDArray[np.float64],
        nonlinear: Nonlinear,
        observations: Observations,
        temperature_c: float | None,
    ) -> list[Lane]:
        """The harmonics that the gateware can correct, at a temperature where that matters.

        Default: the disc-fixed orders of :meth:`disc_orders`.
        """
        return paired_lanes(self.disc_orders(nonlinear), coefficients)

    def conditioned_lanes(
        self,
        coefficients: NDArray[np.float64],
        nonlinear: Nonlinear,
        observations: Observations,
    ) -> list[ConditionedLane]:
        """What lanes can correct whose amplitude follows a condition; default none."""
        return []

    def real_lanes(
        self,
        coefficients: NDArray[np.float64],
        nonlinear: Nonlinear,
        observations: Observations,
    ) -> list[RealLane]:
        """Give the lines of no whole order that lanes can correct; default none."""
        return []

    def local_error(
        self, coefficients: NDArray[np.float64], nonlinear: Nonlinear
    ) -> LocalError | None:
        """Give what a local table of the gateware can correct; default nothing."""
        return None

    @property
    def parts(self) -> list[str]:
        """Public names of the parts that it is put together from; none: an effect of its own."""
        return []

    @property
    def unconditional_orders(self) -> bool:
        """True for a product of parts that is orders of the angle, whatever the conditions are."""
        return False

    def describe(self, parameters: Mapping[str, Parameter]) -> str:
        """The effect in a few words, with its size; the default is its name."""
        return self.name

    def concerns(self, observations: Observations) -> bool:
        """Does the set speak of the part that this effect is of? False: it is not asked about.

        An effect whose :meth:`missing` columns no other machine has stays silent there.
        """
        return True

    def missing(self, observations: Observations) -> list[str]:
        """What the set lacks for a test of this effect, in words; empty: it can be tested."""
        return []

    def variety(self, observations: Observations) -> list[str]:
        """Which variety of conditions the set lacks to tell this effect from its like, in words.

        Such an effect can be fitted, but it is not named; it may share a class with another.
        """
        return []

    def contradiction(
        self,
        coefficients: NDArray[np.float64],
        covariance: NDArray[np.float64],
        nonlinear: Nonlinear,
        observations: Observations,
    ) -> str | None:
        """Why the fitted values are not those of this effect, in words; None: they may be.

        For what its physics asks of the values beyond the shape of its columns. An effect that
        contradicts itself is not named. A test here should refuse a true one less often than
        :data:`CONTRADICTED_P`.
        """
        return None

    def constant_between_heads_arcsec(self, coefficients: NDArray[np.float64]) -> float:
        """The most that it may add to the constant of R₂ − R₁ that its columns do not have."""
        return 0.0

    def search_contradiction(
        self, found: Mapping[str, Parameter], observations: Observations
    ) -> str | None:
        """Why the search parameters that were found are not those of this effect, in words.

        ``found``: every fitted parameter, those of the search with their σ at the maximum of the
        likelihood. None: they may be.
        """
        return None

    @abstractmethod
    def column_names(self, observations: Observations) -> list[str]:
        """One name a coefficient, for instance ``cos 3``."""

    def column_runs(self, observations: Observations) -> tuple[int | None, ...]:
        """The run of the capture that each coefficient belongs to; None: to the whole set.

        Default: no coefficient belongs to one run.
        """
        return (None,) * len(self.column_names(observations))

    def capture_columns(
        self, rows: CaptureRows, nonlinear: Nonlinear, context: FitContext
    ) -> Columns | None:
        """What each coefficient adds to R₂ − R₁, arcseconds; None: nothing at all."""
        return None

    def reference_columns(
        self, rows: ReferenceRows, nonlinear: Nonlinear, context: FitContext
    ) -> Columns | None:
        """What each coefficient adds to ε of head 1, arcseconds; None: nothing at all."""
        return None

    def capture_formula(
        self, rows: CaptureRows, parameters: Mapping[str, float], context: FitContext
    ) -> NDArray[np.float64] | None:
        """R₂ − R₁ of the effect in arcseconds, shape (rows,), written down from the physics.

        ``parameters``: every coefficient and search parameter by name. No fit uses it: ``arctrue
        effects check`` compares its finite differences with the columns. None: not given.
        """
        return None

    def reference_formula(
        self, rows: ReferenceRows, parameters: Mapping[str, float], context: FitContext
    ) -> NDArray[np.float64] | None:
        """The same for ε of head 1."""
        return None

    def told(self, nonlinear: Nonlinear, observations: Observations) -> str:
        """What this set tells of the form that was found, in a sentence; empty: nothing more."""
        return ""

    def seen(self, parameters: Mapping[str, Parameter]) -> str:
        """Describe the fitted values in a sentence; empty: :meth:`told` has said it all."""
        return ""

    def derived(
        self, parameters: Mapping[str, Parameter], nonlinear: Nonlinear, observations: Observations
    ) -> dict[str, Parameter]:
        """Parameters that follow from fitted ones and their σ: a period from a frequency."""
        return {}

    def search_range(self, name: str) -> tuple[float, float]:
        """Smallest and largest value of a search parameter, as the settings may narrow it."""
        parameter = next(item for item in self.search if item.name == name)
        return parameter.low, parameter.high

    def narrowed(self, residuals: Leftover) -> tuple[Effect, float]:
        """The effect with no more settings than the residuals ask for; how many were tried.

        The diagnosis judges this one, so that an effect of many orders is not charged for those
        that are not there. The default is the effect as it is.
        """
        return self, 1.0

    def at_place(
        self, residuals: Leftover, nonlinear: Nonlinear
    ) -> tuple[Effect, dict[str, float]]:
        """The form and the place to which those that a search found lead; the default: the same."""
        return self, dict(nonlinear)

    def parameters(
        self,
        coefficients: NDArray[np.float64],
        covariance: NDArray[np.float64],
        nonlinear: Nonlinear,
        observations: Observations,
    ) -> dict[str, Parameter]:
        """The fitted effect as people read it. Default: every coefficient in arcseconds.

        σ of a search parameter is put in by the fit, which knows the tangents of the columns.
        """
        names = self.column_names(observations)
        sigma = np.sqrt(np.diag(covariance))
        found = {
            name: Parameter(float(value), float(error), "arcsec")
            for name, value, error in zip(names, coefficients, sigma, strict=True)
        }
        for parameter in self.search:
            found[parameter.name] = Parameter(
                nonlinear[parameter.name], float("nan"), parameter.unit
            )
        return found


def paired_real_lanes(orders: Sequence[float], coefficients: NDArray[np.float64]) -> list[RealLane]:
    """Give a lane for every order; ``coefficients`` are its cosine and sine, (2·orders,)."""
    pairs = coefficients.reshape(-1, 2)
    return [
        RealLane(order, float(cosine), float(sine))
        for order, (cosine, sine) in zip(orders, pairs, strict=True)
    ]


def paired_lanes(orders: Sequence[int], coefficients: NDArray[np.float64]) -> list[Lane]:
    """Lanes of cos, sin coefficient pairs, one pair an order."""
    return [
        Lane(order, float(coefficients[2 * index]), float(coefficients[2 * index + 1]))
        for index, order in enumerate(orders)
    ]


def amplitude_and_phase(
    cosine: float, sine: float, covariance: NDArray[np.float64], prefix: str, unit: str = "arcsec"
) -> dict[str, Parameter]:
    """c·cos x + s·sin x as amplitude·cos(x + phase), with standard uncertainties.

    ``covariance`` is the 2 × 2 block of (c, s). The phase has a uniform distribution's
    uncertainty (180°/√3) at most.
    """
    amplitude = float(np.hypot(cosine, sine))
    direction = np.array([cosine, sine]) / amplitude if amplitude > 0.0 else np.array([1.0, 0.0])
    across = np.array([-direction[1], direction[0]])
    along_sigma = float(np.sqrt(max(float(direction @ covariance @ direction), 0.0)))
    across_sigma = float(np.sqrt(max(float(across @ covariance @ across), 0.0)))
    limit = float(180.0 / np.sqrt(3.0))
    phase_sigma = (
        min(float(np.degrees(across_sigma / amplitude)), float(limit)) if amplitude > 0.0 else limit
    )
    return {
        f"{prefix}amplitude": Parameter(amplitude, along_sigma, unit),
        f"{prefix}phase": Parameter(
            float(np.degrees(np.arctan2(-sine, cosine))), phase_sigma, "deg"
        ),
    }
