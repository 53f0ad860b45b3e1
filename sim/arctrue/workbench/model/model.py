"""Defines the data of a model: a list of effects with settings, fitted values and a history."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated

from msgspec import Meta, Struct

from arctrue.base.similar import did_you_mean
from arctrue.base.typed_content import Number
from arctrue.base.units import ARCSEC_PER_DEG
from arctrue.calibration.head_separation import NOMINAL_TOLERANCE_ARCSEC
from arctrue.workbench.effects.base import Effect, Parameter
from arctrue.workbench.effects.registry import effect_class
from arctrue.workbench.inference.design_matrix import Term

Channels = dict[str, Number]
"""One number for each measured channel; the keys are ``capture`` and ``reference``."""


@dataclass
class ModelEffect:
    """One effect of a model; coefficients are empty until a fit has found them.

    Parameters
    ----------
    name : str
        Public name of the effect.
    settings : dict, optional
        Settings that differ from the effect's defaults.
    search : dict of str to float, optional
        Values of the search parameters, in their units.
    columns : list of str, optional
        One name per coefficient.
    coefficients : list of float, optional
        Fitted values, arcseconds or the effect's own unit.
    parameters : dict of str to Parameter, optional
        The fitted quantities that reports show: value, standard uncertainty, unit.
    """

    name: str
    settings: dict[str, object] = field(default_factory=dict)
    search: dict[str, float] = field(default_factory=dict)
    columns: list[str] = field(default_factory=list)
    coefficients: list[float] = field(default_factory=list)
    parameters: dict[str, Parameter] = field(default_factory=dict)

    def effect(self, effects: Mapping[str, type[Effect]]) -> Effect:
        """Make the effect with its settings.

        Parameters
        ----------
        effects : mapping of str to type
            The class of each effect, by its name.

        Returns
        -------
        Effect
            The effect with these settings.

        Raises
        ------
        ValueError
            A name, setting or search parameter is not known; some search parameters are given and
            others are missing; a search parameter lies outside its declared range.
        """
        effect = effect_class(self.name, dict(effects))(**self.settings)
        known = [item.name for item in effect.search]
        for name, value in self.search.items():
            if name not in known:
                raise ValueError(
                    f"effect {self.name}: unknown search parameter {name}."
                    f"{did_you_mean(name, known)} It has: {', '.join(known) or 'none'}"
                )
            low, high = effect.search_range(name)
            if not low <= value <= high:
                raise ValueError(
                    f"effect {self.name}: search parameter {name}: expected a number from {low:g} "
                    f"to {high:g}, found {value:g}"
                )
        lacking = [name for name in known if name not in self.search]
        if self.search and lacking:
            raise ValueError(
                f"effect {self.name}: search parameter {lacking[0]} is missing: give all of "
                f"{', '.join(known)}, or none, so that a search finds them"
            )
        return effect

    def term(self, effects: Mapping[str, type[Effect]]) -> Term:
        """Make the effect a term of a fit.

        Parameters
        ----------
        effects : mapping of str to type
            The class of each effect, by its name.

        Returns
        -------
        Term
            The term with its search parameters.

        Raises
        ------
        ValueError
            The search parameters are not known yet.
        """
        effect = self.effect(effects)
        if effect.search and not self.search:
            raise ValueError(f"{self.name}: the model has no search parameters; fit it first")
        return Term(effect, dict(self.search))


class HistoryStep(Struct, forbid_unknown_fields=True, omit_defaults=True):
    """One change of the model, its result, and the set to which the changed model was fitted."""

    action: str = ""
    """The change that was made: fit, add, set or drop."""
    effect: str = ""
    measurement: str = ""
    rms_arcsec: Channels = {}
    peak_arcsec: Channels = {}
    heldout_rms_arcsec: Channels = {}
    noise_arcsec: Channels = {}
    date: str = ""
    """Date and time in UTC, ISO 8601; empty in files of versions that did not write it."""
    program: str = ""
    """Name and version of the program that made the step."""
    measurement_sha256: str = ""
    """Digest of the set to which the model was fitted, see
    :func:`arctrue.measurement.digest.set_digest`."""


class ModelTable(Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """The table that a model describes; the model's coefficients apply to no other table."""

    counts_per_rev: Annotated[int, Meta(ge=1)] | None = None
    head_separation_deg: Number | None = None

    def completed(self, other: ModelTable | None) -> ModelTable:
        """Fill missing values from another description of the table.

        Parameters
        ----------
        other : ModelTable or None
            Another description of the same table.

        Returns
        -------
        ModelTable
            The table with all values that either description states.
        """
        if other is None:
            return self
        return ModelTable(
            self.counts_per_rev if self.counts_per_rev is not None else other.counts_per_rev,
            self.head_separation_deg
            if self.head_separation_deg is not None
            else other.head_separation_deg,
        )

    def differences(self, other: ModelTable) -> list[str]:
        """List the differences of two tables, except separations within the mounting tolerance.

        Parameters
        ----------
        other : ModelTable
            The table of the set.

        Returns
        -------
        list of str
            Descriptions of the differences; empty if both descriptions may belong to the same
            table.
        """
        found = []
        ours, theirs = self.counts_per_rev, other.counts_per_rev
        if ours is not None and theirs is not None and ours != theirs:
            found.append(f"{ours} counts a turn, the set {theirs}")
        here, there = self.head_separation_deg, other.head_separation_deg
        if here is not None and there is not None:
            apart_arcsec = abs(math.remainder(here - there, 360.0)) * ARCSEC_PER_DEG
            if apart_arcsec > NOMINAL_TOLERANCE_ARCSEC:
                found.append(f"{here:g}° between the heads, the set {there:g}°")
        return found


@dataclass
class Model:
    """A list of effects, the folders of the user's effects, and the history.

    Parameters
    ----------
    effects : list of ModelEffect
        The effects, in the order of the model file.
    history : list of HistoryStep, optional
        The changes of the model, with the error after each change.
    reference_offset_arcsec : float, optional
        The constant a₀ of the reference, arcseconds.
    """

    effects: list[ModelEffect]
    folders: list[str] = field(default_factory=list)
    """Folders of the user's own effects, as written in the model file."""
    history: list[HistoryStep] = field(default_factory=list)
    reference_offset_arcsec: float = 0.0
    reference_temperature_c: float | None = None
    """Reference temperature T₀ of the coefficients, °C; None before a fit to a set with
    temperatures."""
    table: ModelTable | None = None
    """The table that the coefficients belong to; None before a fit, and in old files."""

    def names(self) -> list[str]:
        """List the names of the effects.

        Returns
        -------
        list of str
            The names in the order of the effects.
        """
        return [effect.name for effect in self.effects]

    def terms(self, effects: Mapping[str, type[Effect]]) -> list[Term]:
        """Make all effects terms of a fit.

        Parameters
        ----------
        effects : mapping of str to type
            The class of each effect, by its name.

        Returns
        -------
        list of Term
            The terms in the order of the effects.

        Raises
        ------
        ValueError
            The search parameters of an effect are not known yet.
        """
        return [effect.term(effects) for effect in self.effects]


def default_model() -> Model:
    """Make the paper's model: graduation harmonics of orders 1 to 20, nominal angle α of the heads.

    Returns
    -------
    Model
        The model, not yet fitted.
    """
    return Model([ModelEffect("graduation_harmonics")])
