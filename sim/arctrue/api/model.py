"""Defines the model of the Python interface: effects, fitted values and the history of the fits."""

from __future__ import annotations

import html
from collections.abc import Iterable
from copy import deepcopy
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from arctrue.api.pictures import Pictures, html_table, pictures
from arctrue.api.sets import SetOrFolder, set_of
from arctrue.workbench.effects.base import Effect
from arctrue.workbench.effects.registry import catalogue, effect_class
from arctrue.workbench.model import HistoryStep, ModelEffect, default_model
from arctrue.workbench.model import Model as _Model
from arctrue.workbench.model.growth import add_effect, drop_effect
from arctrue.workbench.model.model_file import read_model, write_model
from arctrue.workbench.model.provenance import with_provenance
from arctrue.workbench.observations import Observations
from arctrue.workbench.observations.build import observations_of


@dataclass(frozen=True, repr=False)
class Model:
    """The effects that a table is known to have; a method that changes effects returns a new model.

    Parameters
    ----------
    content : arctrue.workbench.model.Model, optional
        Effects, fitted values and history; by default the model of the paper (docs/paper.md), which
        is ``graduation_harmonics`` with the orders 1 to 20.
    folders : tuple of Path, optional
        Folders of the user's own effects.
    """

    content: _Model = field(default_factory=default_model)
    folders: tuple[Path, ...] = ()

    @classmethod
    def read(cls, file: Path | str) -> Model:
        """Read a model file.

        Parameters
        ----------
        file : Path or str
            The file, as ``arctrue add --model`` writes it.

        Returns
        -------
        Model
            The model, with the folders of the user's own effects that the file names.

        Raises
        ------
        ModelFileError
            The file is missing, or not a model.
        """
        content = read_model(Path(file))
        return cls(content, tuple(Path(file).parent / folder for folder in content.folders))

    def write(self, file: Path | str) -> None:
        """Write the model file.

        Parameters
        ----------
        file : Path or str
            The file; an existing file is replaced.

        Raises
        ------
        OSError
            The file cannot be written.
        """
        write_model(Path(file), self.content)

    def __repr__(self) -> str:
        """Return the names of the effects; the coefficients would be pages."""
        return f"Model(effects={self.effects})"

    @property
    def effects(self) -> list[str]:
        """Names of the effects, in order."""
        return self.content.names()

    @property
    def history(self) -> list[HistoryStep]:
        """Steps of the history, one per fit, each with errors, date, program and hash of the
        set."""
        return list(self.content.history)

    def having(self, *effects: str, **settings: dict[str, object]) -> Model:
        """Put effects into the model without fitting them.

        Parameters
        ----------
        *effects : str
            Names of effects (``arctrue effects``).
        **settings : dict
            The settings of an effect, by its name: ``graduation_harmonics={"orders": [1, 2]}``. If
            the model has the effect, these settings replace the present settings.

        Returns
        -------
        Model
            The model with these effects; :func:`arctrue.fit` finds their values.

        Raises
        ------
        EffectNotFoundError
            No effect has that name.
        ValueError
            A setting is not known, or not of the right type.
        """
        known = self.known()
        entries = list(self.content.effects)
        for name in dict.fromkeys([*effects, *settings]):
            effect_class(name, known)
            entry = ModelEffect(name, deepcopy(dict(settings.get(name, {}))))
            entry.effect(known)
            there = [place for place, one in enumerate(entries) if one.name == name]
            if there and name in settings:
                entries[there[-1]] = entry
            elif not there:
                entries.append(entry)
        return Model(replace(self.content, effects=entries), self.folders)

    def add(self, effect: str, measurement: SetOrFolder, **settings: object) -> Model:
        """Add an effect and fit the model again.

        Parameters
        ----------
        effect : str
            Name of the effect (``arctrue effects``).
        measurement : MeasurementSet, Path or str
            The set, or the name of its folder.
        **settings
            Settings of the effect.

        Returns
        -------
        Model
            The model with the effect; a new step of its history shows the errors before and after.

        Raises
        ------
        EffectNotFoundError
            No effect has that name.
        NotTestableError
            The set lacks data that the effect needs.
        MeasurementError
            The folder cannot be read.
        """
        data = set_of(measurement)
        content, _ = add_effect(
            self.content, effect, settings, self.observations(data), self.known(), data.label
        )
        return self.grown(content, data)

    def drop(self, effect: str, measurement: SetOrFolder) -> Model:
        """Drop the last effect with this name and fit the remaining effects again.

        Parameters
        ----------
        effect : str
            Name of the effect.
        measurement : MeasurementSet, Path or str
            The set, or the name of its folder.

        Returns
        -------
        Model
            The model without the effect; a new step of its history shows the errors before and
            after.

        Raises
        ------
        ValueError
            The model lacks this effect, or has no other effect.
        MeasurementError
            The folder cannot be read.
        """
        data = set_of(measurement)
        content, _ = drop_effect(
            self.content, effect, self.observations(data), self.known(), data.label
        )
        return self.grown(content, data)

    def grown(self, content: _Model, measurement: SetOrFolder) -> Model:
        """Return this model with other content and the provenance of each new step.

        Parameters
        ----------
        content : arctrue.workbench.model.Model
            Content whose history continues the history of this model.
        measurement : MeasurementSet, Path or str
            The fitted set.

        Returns
        -------
        Model
            The model; every newer step has date, program and hash of the set.
        """
        data = set_of(measurement)
        return Model(with_provenance(content, len(self.content.history), data.sha256), self.folders)

    def known(self) -> dict[str, type[Effect]]:
        """List all effects, including the user's own.

        Returns
        -------
        dict of str to type
            The class of each effect, by its name.
        """
        return catalogue(list(self.folders))

    def observations(self, measurement: SetOrFolder) -> Observations:
        """Prepare the rows of a set, with their conditions, for a fit of this model.

        Parameters
        ----------
        measurement : MeasurementSet, Path or str
            The set, or the name of its folder.

        Returns
        -------
        Observations
            Rows of both channels, angles in radians.

        Raises
        ------
        MeasurementError
            The folder cannot be read.
        """
        return observations_of(
            set_of(measurement), reference_temperature_c=self.content.reference_temperature_c
        )

    def plot(self) -> Pictures:
        """Draw the error after each step of the history.

        Returns
        -------
        Pictures
            A chart with the error after each step of the history.

        Raises
        ------
        ValueError
            The model has no history.
        MissingExtraError
            matplotlib is not installed.
        """
        if not self.content.history:
            raise ValueError("the model has no history yet; add an effect first")

        def charts() -> dict[str, Any]:
            from arctrue.report.charts.ladder import ladder

            return {"history": ladder(self.content.history)}

        return pictures(charts)

    def _repr_html_(self) -> str:
        rows = [
            (step.action, step.effect, channel, f"{rms:.4f}", f"{step.peak_arcsec[channel]:.3f}")
            for step in self.content.history
            for channel, rms in step.rms_arcsec.items()
        ]
        said = f"<p>Model: {html.escape(', '.join(self.effects))}</p>"
        return said + (
            html_table(("step", "effect", "channel", "RMS ″", "peak ″"), rows) if rows else ""
        )


ModelLike = Model | Path | str | Iterable[str] | None
"""A model, the name of its file, or names of effects to add to the paper's model; None means the
paper's model.
"""


def model_of(model: ModelLike) -> Model:
    """Return the model that the argument describes.

    Raises ModelFileError, EffectNotFoundError, TypeError.
    """
    if model is None:
        return Model()
    if isinstance(model, Model):
        return model
    if isinstance(model, Path) or (isinstance(model, str) and Path(model).is_file()):
        return Model.read(model)
    if isinstance(model, str):
        return Model.read(model) if model.endswith(".toml") else Model().having(model)
    if isinstance(model, Iterable):
        names = list(model)
        if all(isinstance(name, str) for name in names):
            return Model().having(*names)
    raise TypeError(
        "expected a Model, the name of a model file or names of effects, found "
        f"{type(model).__name__}"
    )


def add(
    effect: str, measurement: SetOrFolder, model: ModelLike = None, **settings: object
) -> Model:
    """Add an effect to a model and fit it, as ``arctrue add`` does.

    Parameters
    ----------
    effect : str
        Name of the effect (``arctrue effects``).
    measurement : MeasurementSet, Path or str
        The set, or the name of its folder.
    model : Model, Path, str or iterable of str, optional
        The model, its file, or names of effects; by default the paper's model.
    **settings
        Settings of the effect.

    Returns
    -------
    Model
        The model with the effect; a new step of its history shows the errors before and after.

    Raises
    ------
    EffectNotFoundError
        No effect has that name.
    NotTestableError
        The set lacks data that the effect needs.
    """
    return model_of(model).add(effect, measurement, **settings)


def drop(effect: str, measurement: SetOrFolder, model: ModelLike) -> Model:
    """Drop an effect from a model and fit the remaining effects, as ``arctrue drop`` does.

    Parameters
    ----------
    effect : str
        Name of the effect.
    measurement : MeasurementSet, Path or str
        The set, or the name of its folder.
    model : Model, Path, str or iterable of str
        The model, its file, or names of effects.

    Returns
    -------
    Model
        The model without the effect; a new step of its history shows the errors before and after.

    Raises
    ------
    ValueError
        The model lacks this effect, or has no other effect.
    """
    return model_of(model).drop(effect, measurement)
