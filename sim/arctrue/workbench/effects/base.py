"""Defines the interface of a physical effect to the workbench, which every file in this folder
implements.

An effect turns the conditions of each measured row (angle, time, temperature, direction, ...) into
columns of the design matrix; the fit finds one coefficient per column, common to the rows of the
capture and of the reference run. If the columns depend on further unknowns (an order, a frequency,
an instant), the effect declares these as search parameters, with the kind of search that finds
them.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from arctrue.base.similar import did_you_mean
from arctrue.base.units import RAD_PER_ARCSEC

if TYPE_CHECKING:
    from arctrue.workbench.observations import CaptureRows, Observations, ReferenceRows

Columns = NDArray[np.float64]
"""Columns of a design matrix, shape (rows, coefficients)."""

Nonlinear = Mapping[str, float]
"""Values of the search parameters, by name."""

Compensation = Literal["lanes", "offset", "modulators", "local_table", "none", "reference"]
"""The part of the gateware that can correct an effect: ``lanes`` (harmonics of the angle),
``offset`` (a constant), ``modulators`` (lanes whose amplitudes follow a condition) or
``local_table`` (an error at one place of the turn); ``none``: no part. ``reference``: the reference
has the error, not the table, so every evaluation of the table excludes it."""


SearchKind = Literal[
    "grid", "disc_order", "unwrapped_order", "frequency", "line", "step", "disc_place"
]
"""Kinds of search for the parameters of an effect. In this order, they find: every point of the
declared ranges; a whole order of the disc; an order over the unwrapped angle; a frequency in time;
a line, which is an order or a frequency in either channel; the instant of a step in a run; place
and width of a bump on the disc."""

SEARCHED: Mapping[SearchKind, frozenset[str]] = {
    "disc_order": frozenset({"order"}),
    "unwrapped_order": frozenset({"order"}),
    "frequency": frozenset({"frequency"}),
    "line": frozenset({"order", "frequency", "in_time", "in_capture"}),
    "step": frozenset({"run", "instant"}),
    "disc_place": frozenset({"place", "width"}),
}
"""Names of the search parameters that each kind of search finds; a grid search finds all that an
effect declares."""


class Gain(Protocol):
    """The improvement of the fit when a block of columns is added to the model."""

    @property
    def gain(self) -> float:
        """Return twice the increase of the log likelihood; the noise model stays fixed."""


class Leftover(Protocol):
    """Residuals of the model; :meth:`score` returns the gain of additional columns."""

    observations: Observations

    def score(self, effect: Effect, nonlinear: Nonlinear) -> Gain:
        """Return the gain of all columns of an effect, fitted together with the model's columns."""


@dataclass(frozen=True, slots=True)
class Parameter:
    """A fitted quantity that reports show: value, standard uncertainty, unit."""

    value: float
    sigma: float
    unit: str


@dataclass(frozen=True, slots=True)
class Lane:
    """A harmonic of head 1's error that a lane of the gateware can correct."""

    order: int
    cosine_arcsec: float
    sine_arcsec: float


Condition = Literal["direction", "speed", "speed_squared", "column"]
"""The conditions that the amplitude of a lane may follow (the gateware's generic MODULATORS).

``column``: a user's additional column of the set, whose present value the host measures and writes
to a register of the gateware.
"""


@dataclass(frozen=True, slots=True)
class ConditionedLane:
    """A harmonic of head 1's error that is proportional to a condition; order 0: a constant.

    Amplitudes are per unit of the condition: direction ±1, speed in rad/s or its square, or the
    column's unit.
    """

    condition: Condition
    lane: Lane
    column: str = ""
    """Name of the column, if the condition is a column."""
    column_zero: float = 0.0
    """Value of the column at which the condition is 0."""


@dataclass(frozen=True, slots=True)
class RealLane:
    """A harmonic of head 1's error at an order that is not an integer; its phase continues from
    turn to turn (the gateware's generic REAL_ORDERS)."""

    order: float
    cosine_arcsec: float
    sine_arcsec: float


@dataclass(frozen=True, slots=True)
class LocalError:
    """An error of head 1 at one place of the turn (the gateware's generic LOCAL_TABLE)."""

    place_rad: float
    """Reading of the head at the middle of the local error."""
    half_width_rad: float
    """Distance from the middle beyond which the error is negligible."""
    error_arcsec: Callable[[NDArray[np.float64]], NDArray[np.float64]]
    """Function of the head's readings in radians, shape (n,), that returns the error."""


@dataclass(frozen=True, slots=True)
class SearchParameter:
    """A parameter that enters the columns nonlinearly and is therefore searched."""

    name: str
    unit: str
    low: float
    high: float
    meaning: str
    steps: int = 64
    """Number of points of the grid that the default scan tries."""
    integer: bool = False
    """True if only integers have a meaning; the search does not refine such a parameter between its
    grid points."""


CONTRADICTED_P = 0.005
"""Largest probability with which a check of an effect's physics may refuse a true effect: half of
the 1 % that the diagnosis allows for false names."""


@dataclass(frozen=True)
class FitContext:
    """The fitted error function and coefficients, for effects whose columns depend on them.

    The error function ε is the error of the graduation, equation (9): arcseconds as a function of
    the disc angle in radians.
    """

    cosine_arcsec: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))
    sine_arcsec: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))
    orders: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    at_angle: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, dtype=np.bool_))
    """True for each order whose columns are evaluated at the true angle, which does not contain the
    lag of the reading. Columns that are evaluated at the reading already contain the lag."""
    coefficients: Mapping[str, NDArray[np.float64]] = field(default_factory=dict)
    """Fitted coefficients of the effects that depend on the model, by name."""

    def shifted_arcsec(
        self, disc_rad: NDArray[np.float64], shift_rad: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return ε(ψ + shift) − ε(ψ) in arcseconds, for the orders at the true angle; shapes
        (rows,)."""
        total = np.zeros_like(disc_rad, dtype=np.float64)
        for order, cosine, sine, there in zip(
            self.orders, self.cosine_arcsec, self.sine_arcsec, self.at_angle, strict=True
        ):
            if there:
                # cos(a + s) − cos a = −2 sin(a + s/2) sin(s/2) avoids the difference of nearly
                # equal numbers.
                middle, half = order * (disc_rad + 0.5 * shift_rad), 0.5 * order * shift_rad
                total += 2.0 * np.sin(half) * (sine * np.cos(middle) - cosine * np.sin(middle))
        return total

    def error_arcsec(self, disc_rad: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return ε(ψ) in arcseconds, in the shape of ``disc_rad``."""
        total = np.zeros_like(disc_rad, dtype=np.float64)
        for order, cosine, sine in zip(
            self.orders, self.cosine_arcsec, self.sine_arcsec, strict=True
        ):
            phase = order * disc_rad
            total += cosine * np.cos(phase) + sine * np.sin(phase)
        return total

    def error_slope(self, disc_rad: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return dε/dψ in arcseconds per arcsecond, in the shape of ``disc_rad``."""
        total = np.zeros_like(disc_rad, dtype=np.float64)
        for order, cosine, sine in zip(
            self.orders, self.cosine_arcsec, self.sine_arcsec, strict=True
        ):
            phase = order * disc_rad
            total += order * (sine * np.cos(phase) - cosine * np.sin(phase))
        return total * RAD_PER_ARCSEC


def _lists_integers(default: object) -> bool:
    """Tell whether a setting with this default lists whole numbers."""
    return (
        isinstance(default, list)
        and bool(default)
        and all(isinstance(value, int) and not isinstance(value, bool) for value in default)
    )


FORMER_NAMES = {
    "told_apart_by": "separated_by", "told": "describe_data", "seen": "describe_values",
}  # fmt: skip


def orders_of_parts(parts: Iterable[str]) -> tuple[float, ...]:
    """Return the orders among public names of parts (``order:1``)."""
    found = [name.partition(":") for name in parts]
    return tuple(float(order) for kind, _, order in found if kind == "order")


class Effect(ABC):
    """Base class of a physical effect. Each subclass is in a file of its own; built-in effects use
    no other interface than users' effects."""

    name: ClassVar[str]
    """Public name, as used on the command line, in model files and in JSON."""
    physics: ClassVar[str]
    """Description of the physical cause, in two sentences."""
    equation: ClassVar[str]
    source: ClassVar[str]
    capture_sees: ClassVar[str]
    """Description of the effect's appearance in the difference of the two heads."""
    reference_sees: ClassVar[str]
    """Description of the effect's appearance in a reference run."""
    separated_by: ClassVar[str]
    next_measurement: ClassVar[str]
    """Description of the measurement that would show this effect best, or distinguish it from
    similar effects."""
    plausible: ClassVar[str]
    """Range of sizes that have been observed."""
    compensation: ClassVar[Compensation] = "none"
    compensation_note: ClassVar[str] = ""
    search: ClassVar[tuple[SearchParameter, ...]] = ()
    search_kind: ClassVar[SearchKind] = "grid"
    defaults: ClassVar[Mapping[str, object]] = {}
    """Settings and their default values."""
    parameter_units: ClassVar[Mapping[str, str]] = {}
    """The main parameters that :meth:`parameters` returns, with their units."""
    depends_on_model: ClassVar[bool] = False
    """True if the columns depend on the fitted error function, so that the fit must be repeated."""
    at_reading: ClassVar[bool] = False
    """Whether the effect's disc orders are evaluated at the reading of a head, not at the true
    angle."""
    step_at: ClassVar[tuple[str, str] | None] = None
    """Search parameters (run, instant) at which the only column steps from 0 to 1."""
    longest_call_s: ClassVar[float] = 60.0
    """Longest time in seconds of one call of a method of a user's file; a longer call raises an
    error."""
    needs_settings: ClassVar[bool] = False
    """Whether the effect needs settings; without them the diagnosis does not test it."""
    unspecific: ClassVar[bool] = False
    """Whether the effect describes the observation, not its cause: a more specific effect that fits
    as well is named in its place."""
    in_parts: ClassVar[tuple[str, ...]] = ()
    """The product of parts that equals the effect by definition, on every set; empty if there is no
    such product."""
    local_on_disc: ClassVar[bool] = False
    """Whether the effect acts on a short arc of the disc, so that every turn must show it."""
    of_the_signal: ClassVar[bool] = False
    """Whether the effect repeats with the signal period of the grating."""
    multiples_setting: ClassVar[str | None] = None
    """Name of the setting that lists multiples of :meth:`declared_order`."""
    moves_axis: ClassVar[bool] = False
    """Whether the effect shifts the axis relative to the heads: their weighted mean does not
    contain it."""
    fixed_to_polygon: ClassVar[bool] = False
    """Whether the effect moves with the polygon when the polygon is turned on the table by some
    faces."""

    def __init_subclass__(cls, **of_class: Any) -> None:
        """Accept declarations under their former names, for one release."""
        super().__init_subclass__(**of_class)
        for former, name in FORMER_NAMES.items():
            if former in cls.__dict__ and name not in cls.__dict__:
                setattr(cls, name, cls.__dict__[former])

    def __init__(self, **settings: object) -> None:
        """Check and store the settings.

        Raises ValueError for a setting that this effect does not have, or of a wrong type.
        """
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
        for key in settings:
            if _lists_integers(self.defaults[key]):
                self.integers(key)

    def integers(self, key: str) -> tuple[int, ...]:
        """Return a setting that lists whole numbers above 0, each once. Raises ValueError if the
        setting has other values."""
        values = self.settings[key]
        if (
            not isinstance(values, Sequence)
            or not all(
                isinstance(value, int) and not isinstance(value, bool) and value > 0
                for value in values
            )
            or len(set(values)) != len(values)
        ):
            raise ValueError(
                f"effect {self.name}: setting {key} must list whole numbers above 0, each once, "
                f"found {values!r}"
            )
        return tuple(values)

    def declared_order(self, observations: Observations) -> float | None:
        """Return the order, such as a tooth count, that the set states and whose multiples the
        effect contains; otherwise None."""
        return None

    def disc_orders(self, nonlinear: Nonlinear) -> Sequence[int]:
        """Return the orders of ε(ψ) whose cosine and sine coefficients belong to the effect's first
        columns."""
        return ()

    def electrical_orders(self, observations: Observations) -> Sequence[float]:
        """Return the periods per turn of each column if the columns are waves of the electrical
        phase of a head; otherwise an empty list."""
        return ()

    def lanes(
        self,
        coefficients: NDArray[np.float64],
        nonlinear: Nonlinear,
        observations: Observations,
        temperature_c: float | None,
    ) -> list[Lane]:
        """Return the harmonics that the gateware can correct, at a temperature if they depend on
        it.

        Default: the disc-fixed orders of :meth:`disc_orders`.
        """
        return paired_lanes(self.disc_orders(nonlinear), coefficients)

    def conditioned_lanes(
        self,
        coefficients: NDArray[np.float64],
        nonlinear: Nonlinear,
        observations: Observations,
    ) -> list[ConditionedLane]:
        """Return the harmonics for lanes that follow a condition; by default none.

        An effect with the compensation "lanes" may have such lanes in addition to :meth:`lanes`.
        """
        return []

    def real_lanes(
        self,
        coefficients: NDArray[np.float64],
        nonlinear: Nonlinear,
        observations: Observations,
    ) -> list[RealLane]:
        """Return the harmonics for lanes of orders that are not integers; by default none."""
        return []

    def local_error(
        self, coefficients: NDArray[np.float64], nonlinear: Nonlinear
    ) -> LocalError | None:
        """Return the error that a local table of the gateware can correct; by default None."""
        return None

    @property
    def parts(self) -> list[str]:
        """Return the public names of the effect's parts; an empty list means an effect without
        parts."""
        return []

    @property
    def unconditional_orders(self) -> bool:
        """Tell whether the effect is a product of parts with orders of the angle and no
        condition."""
        return False

    def describe(self, parameters: Mapping[str, Parameter]) -> str:
        """Describe the effect in a few words, with its size; the default is its name."""
        return self.name

    def concerns(self, observations: Observations) -> bool:
        """Tell whether the set has data on the part of a machine that causes the effect.

        If False, the diagnosis neither tests the effect nor lists it as not tested.
        """
        return True

    def missing(self, observations: Observations) -> list[str]:
        """List in words the data that the set lacks for a test of this effect; empty if it can be
        tested."""
        return []

    def variety(self, observations: Observations) -> list[str]:
        """List in words the missing variety of conditions that would separate the effect from
        similar effects.

        Without this variety, the effect can be fitted, but is not named; it may share a class with
        another effect.
        """
        return []

    def contradiction(
        self,
        coefficients: NDArray[np.float64],
        covariance: NDArray[np.float64],
        nonlinear: Nonlinear,
        observations: Observations,
    ) -> str | None:
        """Explain in words why this effect cannot have the fitted values; return None if it can.

        The check covers what the effect's physics requires of the values in addition to the shape
        of its columns. An effect whose values contradict its physics is not named. A check should
        refuse a true effect less often than :data:`CONTRADICTED_P`.
        """
        return None

    def constant_between_heads_arcsec(self, coefficients: NDArray[np.float64]) -> float:
        """Return the largest constant, ″, that the effect may add to R₂ − R₁ without a column."""
        return 0.0

    def search_contradiction(
        self, found: Mapping[str, Parameter], observations: Observations
    ) -> str | None:
        """Explain in words why this effect cannot have the search parameters that were found.

        ``found``: every fitted parameter; search parameters have their σ at the maximum of the
        likelihood. The result is None if the effect can have them.
        """
        return None

    @abstractmethod
    def column_names(self, observations: Observations) -> list[str]:
        """Return one name per coefficient, for instance ``cos 3``."""

    def column_runs(self, observations: Observations) -> tuple[int | None, ...]:
        """Return, for each coefficient, the run of the capture that it belongs to; None: the whole
        set.

        Default: no coefficient belongs to one run.
        """
        return (None,) * len(self.column_names(observations))

    def capture_columns(
        self, rows: CaptureRows, nonlinear: Nonlinear, context: FitContext
    ) -> Columns | None:
        """Return the contribution of each coefficient to R₂ − R₁, arcseconds; None: the effect does
        not change it."""
        return None

    def reference_columns(
        self, rows: ReferenceRows, nonlinear: Nonlinear, context: FitContext
    ) -> Columns | None:
        """Return the contribution of each coefficient to ε of head 1, arcseconds; None: the effect
        does not change it."""
        return None

    def capture_formula(
        self, rows: CaptureRows, parameters: Mapping[str, float], context: FitContext
    ) -> NDArray[np.float64] | None:
        """Return R₂ − R₁ of the effect in arcseconds, shape (rows,), directly from the physics.

        ``parameters``: every coefficient and search parameter by name. No fit uses this method:
        ``arctrue effects check`` compares its finite differences with the columns. None: the effect
        has no such formula.
        """
        return None

    def reference_formula(
        self, rows: ReferenceRows, parameters: Mapping[str, float], context: FitContext
    ) -> NDArray[np.float64] | None:
        """Return ε of head 1 in arcseconds, shape (rows,), directly from the physics."""
        return None

    def describe_data(self, nonlinear: Nonlinear, observations: Observations) -> str:
        """Describe in words what the data show about the effect; empty if there is nothing to
        add."""
        return ""

    def describe_values(self, parameters: Mapping[str, Parameter]) -> str:
        """Describe the fitted values in a sentence; empty if :meth:`describe_data` states them."""
        return ""

    def derived(
        self, parameters: Mapping[str, Parameter], nonlinear: Nonlinear, observations: Observations
    ) -> dict[str, Parameter]:
        """Return parameters that follow from fitted parameters and their σ, such as a period from a
        frequency."""
        return {}

    def search_range(self, name: str) -> tuple[float, float]:
        """Return the smallest and largest value of a search parameter, within the limits that the
        settings give."""
        parameter = next(item for item in self.search if item.name == name)
        return parameter.low, parameter.high

    def narrowed(self, residuals: Leftover) -> tuple[Effect, float]:
        """Return the effect with the settings that the residuals need, and the number of trials.

        The diagnosis tests the returned effect, so that an effect of many orders has a penalty only
        for the orders that the residuals show. Default: the effect as it is.
        """
        return self, 1.0

    def at_place(
        self, residuals: Leftover, nonlinear: Nonlinear
    ) -> tuple[Effect, dict[str, float]]:
        """Return effect and search parameters, adapted to a search's result; default: unchanged."""
        return self, dict(nonlinear)

    def parameters(
        self,
        coefficients: NDArray[np.float64],
        covariance: NDArray[np.float64],
        nonlinear: Nonlinear,
        observations: Observations,
    ) -> dict[str, Parameter]:
        """Return the parameters of the fitted effect that reports show. Default: coefficients in
        arcseconds.

        The fit, which knows the tangents of the columns, inserts the σ of search parameters.
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
    """Return one lane per order; ``coefficients`` are the cosine and sine of each order,
    (2·orders,)."""
    pairs = coefficients.reshape(-1, 2)
    return [
        RealLane(order, float(cosine), float(sine))
        for order, (cosine, sine) in zip(orders, pairs, strict=True)
    ]


def paired_lanes(orders: Sequence[int], coefficients: NDArray[np.float64]) -> list[Lane]:
    """Return one lane per order from the pairs of cosine and sine coefficients."""
    return [
        Lane(order, float(coefficients[2 * index]), float(coefficients[2 * index + 1]))
        for index, order in enumerate(orders)
    ]


def amplitude_and_phase(
    cosine: float, sine: float, covariance: NDArray[np.float64], prefix: str, unit: str = "arcsec"
) -> dict[str, Parameter]:
    """Convert c·cos x + s·sin x to amplitude·cos(x + phase), with standard uncertainties.

    ``covariance`` is the 2 × 2 block of (c, s). The uncertainty of the phase is at most the
    standard deviation of a uniform distribution (180°/√3).
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
