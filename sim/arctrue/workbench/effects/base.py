"""Defines the interface of a physical effect to the workbench, which every file of the catalogue
implements. An effect imports all that it needs from this module.

An effect turns the conditions of each measured row (angle, time, temperature, direction, ...) into
columns of the design matrix; the fit finds one coefficient per column, common to the rows of the
capture and of the reference run. If the columns depend on further unknowns (an order, a frequency,
an instant), the effect declares these as search parameters, with the kind of search that finds
them.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.effects.effect_settings import EffectWithSettings
from arctrue.workbench.effects.fit_context import FitContext
from arctrue.workbench.effects.gateware_lanes import (
    Condition,
    ConditionedLane,
    Lane,
    LocalError,
    RealLane,
    paired_lanes,
    paired_real_lanes,
)
from arctrue.workbench.effects.parameter import Parameter, amplitude_and_phase
from arctrue.workbench.effects.search_parameter import SEARCHED, SearchKind, SearchParameter

if TYPE_CHECKING:
    from arctrue.workbench.observations import CaptureRows, Observations, ReferenceRows

__all__ = [
    "CONTRADICTED_P",
    "SEARCHED",
    "Columns",
    "Compensation",
    "Condition",
    "ConditionedLane",
    "Effect",
    "FitContext",
    "Gain",
    "Lane",
    "Leftover",
    "LocalError",
    "Nonlinear",
    "Parameter",
    "RealLane",
    "SearchKind",
    "SearchParameter",
    "amplitude_and_phase",
    "orders_of_parts",
    "paired_lanes",
    "paired_real_lanes",
]

Columns = NDArray[np.float64]
"""Columns of a design matrix, shape (rows, coefficients)."""

Nonlinear = Mapping[str, float]
"""Values of the search parameters, by name."""

Compensation = Literal["lanes", "offset", "modulators", "local_table", "none", "reference"]
"""The part of the gateware that can correct an effect: ``lanes`` (harmonics of the angle),
``offset`` (a constant), ``modulators`` (lanes whose amplitudes follow a condition) or
``local_table`` (an error at one place of the turn); ``none``: no part. ``reference``: the reference
has the error, not the table, so every evaluation of the table excludes it."""


class Gain(Protocol):
    """The improvement of the fit when a block of columns is added to the model."""

    @property
    def gain(self) -> float:
        """Return twice the increase of the log likelihood; the noise model stays fixed."""


class Leftover(Protocol):
    """Residuals of the model; :meth:`score` returns the gain of additional columns, :meth:`scores`
    the gains of several effects in less time than one by one."""

    observations: Observations

    def score(self, effect: Effect, nonlinear: Nonlinear) -> Gain:
        """Return the gain of all columns of an effect, fitted together with the model's columns."""

    def scores(self, asked: Sequence[tuple[Effect, Nonlinear]]) -> Sequence[Gain]:
        """Return the gain of each effect alone."""

    def reference_excess_arcsec2(self, effect: Effect, nonlinear: Nonlinear) -> float:
        """Return the mean square of the reference's residuals, with an effect in the model, minus
        that of the noise of the repeats."""


@dataclass(frozen=True, slots=True)
class Wave:
    """Columns on the rows of a capture that several effects have in common."""

    key: Hashable
    """Waves of the same rows with equal keys are equal, while their effects exist."""
    width: int
    """Number of columns."""
    columns: Callable[[], Columns]


@dataclass(frozen=True, slots=True)
class OfWaves:
    """The capture columns of an effect as linear combinations of waves."""

    waves: Sequence[Wave]
    factors: Columns
    """Factor of each column of the waves in each column of the effect, (columns of the waves,
    columns)."""


CONTRADICTED_P = 0.005
"""Largest probability with which a check of an effect's physics may refuse a true effect: half of
the 1 % that the diagnosis allows for false names."""


def orders_of_parts(parts: Iterable[str]) -> tuple[float, ...]:
    """Return the orders among public names of parts (``order:1``)."""
    found = [name.partition(":") for name in parts]
    return tuple(float(order) for kind, _, order in found if kind == "order")


class Effect(EffectWithSettings):
    """Base class of a physical effect. Each subclass is in a file of its own; built-in effects use
    no other interface than users' effects."""

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
    parameter_units: ClassVar[Mapping[str, str]] = {}
    """The main parameters that :meth:`parameters` returns, with their units."""
    order_is_stated: ClassVar[bool] = False
    """True if the set states the orders of the effect, such as a number of teeth, so that no search
    can fit them to an error of another cause."""
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
    narrowed_when_added: ClassVar[bool] = False
    """Whether an effect that is added without settings gets those of :meth:`narrowed`, if their
    evidence is better."""
    moves_axis: ClassVar[bool] = False
    """Whether the effect shifts the axis relative to the heads: their weighted mean does not
    contain it."""
    zero_is_unknown: ClassVar[bool] = False
    """Whether the effect is zero at an unknown value of its condition; it then also causes a
    constant. Example: the temperature at which the heads have the stated places is unknown."""
    reversal_of_the_table: ClassVar[str | None] = None
    """Name of the parameter that is a reversal error between table and disc. Both heads read the
    disc, so that this error does not change R₂ − R₁."""
    fixed_to_polygon: ClassVar[bool] = False
    """Whether the effect moves with the polygon when the polygon is turned on the table by some
    faces."""

    def of_waves(self, rows: CaptureRows) -> OfWaves | None:
        """Return :meth:`capture_columns` as combinations of waves, if other effects have the same
        waves: a score test then whitens each wave once. Default: None."""
        return None

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

        The shape of the columns does not express all that the effect's physics requires; the check
        covers the other requirements. An effect whose values contradict its physics is not named. A
        check should refuse a true effect less often than :data:`CONTRADICTED_P`.
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

    def forms(self) -> Sequence[Effect]:
        """Return this effect, and forms of it with search parameters that only some sets need.

        Default: this effect only.
        """
        return [self]

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

        The fit inserts the σ of search parameters, because it has the tangents of the columns.
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
