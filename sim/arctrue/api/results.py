"""Provides compare, diagnose and explain of the Python interface, and their results."""

from __future__ import annotations

import html
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

from arctrue.api.model import Model, ModelLike, model_of
from arctrue.api.pictures import Pictures, html_table, pictures
from arctrue.api.sets import SetOrFolder, set_of
from arctrue.calibration.head_separation import doubts_of
from arctrue.measurement import MeasurementSet
from arctrue.workbench.compare.comparison import ModelComparison
from arctrue.workbench.compare.comparison import compare as _compare
from arctrue.workbench.diagnose.diagnosis import MATTERS_COUNTS
from arctrue.workbench.diagnose.diagnosis import Diagnosis as _Diagnosis
from arctrue.workbench.diagnose.diagnosis import diagnose as _diagnose
from arctrue.workbench.diagnose.report import sentences
from arctrue.workbench.diagnose.report_json import diagnosis_data
from arctrue.workbench.inference.solution import Solution
from arctrue.workbench.model.explain import Explanation as _Explanation
from arctrue.workbench.model.explain import explain as _explain
from arctrue.workbench.model.growth import as_stored, fitted, settle
from arctrue.workbench.model.stations import warnings_of_the_arc
from arctrue.workbench.noise.doubtful_columns import doubtful_columns
from arctrue.workbench.observations import Observations


@dataclass(frozen=True)
class Comparison:
    """Result of a comparison, which shows where a model fails.

    Parameters
    ----------
    data : dict
        ``channels`` (without ``excess_arcsec``) and ``findings``, as ``arctrue compare --json``
        writes them; arcseconds.
    result : ModelComparison
        The same results as objects of the workbench.
    solution : Solution
        The model as it was compared, with its residuals.
    warnings : tuple of str
        Remarks on the set for the user, one sentence each.
    """

    data: dict[str, Any]
    result: ModelComparison = field(repr=False)
    solution: Solution = field(repr=False)
    warnings: tuple[str, ...] = ()

    def plot(self) -> Pictures:
        """Draw the residual over the angle, by run and direction, and its maps.

        Returns
        -------
        Pictures
            The pictures of ``arctrue compare --out``, except the orbit of the axis.

        Raises
        ------
        MissingExtraError
            matplotlib is not installed.
        """
        return comparison_pictures(self.solution, self.result)

    def _repr_html_(self) -> str:
        rows = [
            (name, item.rows, f"{item.rms_arcsec:.4f}", f"{item.peak_arcsec:.3f}",
             f"{item.noise_arcsec:.4f}", f"{item.lack_of_fit_p:.2g}")
            for name, item in self.result.channels.items()
        ]  # fmt: skip
        headings = ("channel", "rows", "RMS ″", "peak ″", "noise of repeats ″", "lack of fit p")
        found = "".join(f"<li>{html.escape(item.text)}</li>" for item in self.result.findings)
        warned = "".join(f"<p>Warning: {html.escape(text)}</p>" for text in self.warnings)
        return warned + html_table(headings, rows) + f"<ul>{found}</ul>"


def comparison_pictures(solution: Solution, result: ModelComparison) -> Pictures:
    """Draw the residual over the angle, by run and direction, and its maps."""

    def charts() -> Any:
        from arctrue.report.charts.comparison_charts import comparison_charts

        return comparison_charts(solution, result)

    return pictures(charts)


@dataclass(frozen=True)
class Diagnosis:
    """Result of a diagnosis: the verdict, and the missing effect if the verdict names one.

    Parameters
    ----------
    verdict : str
        ``named``, ``ambiguous``, ``unknown``, ``adequate``, ``cannot_tell`` or ``bad_data``.
    sentences : tuple of str
        The sentences that ``arctrue diagnose`` prints.
    data : dict
        The content that ``arctrue diagnose --json`` writes.
    result : arctrue.workbench.diagnose.diagnosis.Diagnosis
        The same results as objects of the workbench.
    warnings : tuple of str
        Remarks on the set for the user, one sentence each.
    """

    verdict: str
    sentences: tuple[str, ...]
    data: dict[str, Any] = field(repr=False)
    result: _Diagnosis = field(repr=False)
    warnings: tuple[str, ...] = ()

    def plot(self) -> Pictures:
        """Draw the evidence for each candidate.

        Returns
        -------
        Pictures
            The picture of ``arctrue diagnose --out``.

        Raises
        ------
        ValueError
            Nothing was fitted, because the data are faulty or do not determine a model.
        MissingExtraError
            matplotlib is not installed.
        """
        if self.result.base is None:
            raise ValueError(f"nothing was fitted: the verdict is {self.verdict}")

        def charts() -> Any:
            from arctrue.report.charts.candidates import candidates_chart

            return {"candidates": candidates_chart(self.result)}

        return pictures(charts)

    def _repr_html_(self) -> str:
        texts = [*(f"Warning: {text}" for text in self.warnings), *self.sentences]
        said = "".join(f"<p>{html.escape(text)}</p>" for text in texts)
        return f"<p><b>Verdict: {html.escape(self.verdict)}</b></p>{said}"


@dataclass(frozen=True)
class Explanation:
    """Result of ``explain``: the effects that were added one by one, and the final diagnosis.

    Parameters
    ----------
    model : Model
        The model with the effects that were added; its history has a step for each effect.
    sizes_arcsec : dict of str to float
        Held-out error that each added effect removes, in the channel where it removes most; the
        largest first. If an effect was added twice, the second name ends with " (2)".
    verdict : Diagnosis
        Diagnosis of the final model.
    result : arctrue.workbench.model.explain.Explanation
        The same results as objects of the workbench.
    """

    model: Model
    sizes_arcsec: dict[str, float]
    verdict: Diagnosis
    result: _Explanation = field(repr=False)

    def plot(self) -> Pictures:
        """Draw the error after each step of the history.

        Returns
        -------
        Pictures
            A chart with the error after each step of the model's history.

        Raises
        ------
        MissingExtraError
            matplotlib is not installed.
        """
        return self.model.plot()

    def _repr_html_(self) -> str:
        rows = [(name, f"{size:.4f}") for name, size in self.sizes_arcsec.items()]
        return html_table(("cause", "error removed, ″"), rows) + self.verdict._repr_html_()


def numbered(sizes: Sequence[tuple[str, float]]) -> dict[str, float]:
    """Return the sizes by name; a name that occurs again gets the number of its occurrence."""
    found: dict[str, float] = {}
    count: Counter[str] = Counter()
    for name, size in sizes:
        count[name] += 1
        found[name if count[name] == 1 else f"{name} ({count[name]})"] = size
    return found


def compare(
    measurement: SetOrFolder, model: ModelLike = None, *, fit: bool = True, seed: int = 1
) -> Comparison:
    """Compare a model with a set: how large the misfit is, and on which conditions it depends.

    Parameters
    ----------
    measurement : MeasurementSet, Path or str
        The set, or the name of its folder.
    model : Model, Path, str or iterable of str, optional
        The model, its file, or names of effects; by default the paper's model.
    fit : bool, optional
        If False, use the stored coefficients of the model, as ``--no-fit`` does.
    seed : int, optional
        Seed of the random draws of noise, which show the share of the variance that a condition
        explains by chance.

    Returns
    -------
    Comparison
        RMS, peak, noise and lack of fit of each channel, and findings.

    Raises
    ------
    NotTestableError
        The set lacks data that an effect of the model needs.
    MeasurementError
        The folder cannot be read.
    """
    model, rows = model_of(model), set_of(measurement)
    observations = model.observations(rows)
    if fit:
        _, solution = fitted(model.content, observations, model.known())
    else:
        solution = as_stored(model.content, observations, model.known())
    result = _compare(solution, seed)
    data = {
        "channels": {name: asdict(item) for name, item in result.channels.items()},
        "findings": [asdict(item) for item in result.findings],
    }
    return Comparison(data, result, solution, _warnings(rows, model, observations))


def diagnose(
    measurement: SetOrFolder,
    model: ModelLike = None,
    *,
    matters_counts: float = MATTERS_COUNTS,
) -> Diagnosis:
    """Find the physical effect that the model lacks, or report that the set does not determine it.

    Parameters
    ----------
    measurement : MeasurementSet, Path or str
        The set, or the name of its folder.
    model : Model, Path, str or iterable of str, optional
        The model, its file, or names of effects; by default the paper's model.
    matters_counts : float, optional
        An effect is negligible below this RMS, counts.

    Returns
    -------
    Diagnosis
        Verdict, sentences, and all figures.

    Raises
    ------
    NotTestableError
        The set lacks data that an effect of the model needs.
    MeasurementError
        The folder cannot be read.
    """
    model, rows = model_of(model), set_of(measurement)
    observations = model.observations(rows)
    known = model.known()
    terms = settle(model.content, observations, known)
    result = _diagnose(observations, terms, known, matters_counts=matters_counts)
    return _diagnosis(result, model, _warnings(rows, model, observations))


def _warnings(rows: MeasurementSet, model: Model, observations: Observations) -> tuple[str, ...]:
    """Return the warnings that a command prints for this set and model."""
    return (
        *rows.warnings,
        *doubts_of(rows),
        *observations.left_out,
        *doubtful_columns(observations),
        *warnings_of_the_arc(model.content, observations),
    )


def _diagnosis(result: _Diagnosis, model: Model, warnings: tuple[str, ...]) -> Diagnosis:
    data = diagnosis_data(result, model.effects)
    return Diagnosis(result.verdict, tuple(sentences(result)), data, result, warnings)


def explain(
    measurement: SetOrFolder,
    model: ModelLike = None,
    *,
    matters_counts: float = MATTERS_COUNTS,
) -> Explanation:
    """Add the effects that the diagnosis names, until it names no further effect.

    Parameters
    ----------
    measurement : MeasurementSet, Path or str
        The set, or the name of its folder.
    model : Model, Path, str or iterable of str, optional
        The model to begin with, its file, or names of effects; by default the paper's model.
    matters_counts : float, optional
        An effect is negligible below this RMS, counts.

    Returns
    -------
    Explanation
        The model with the added effects, the size of each cause, and the verdict on this model.

    Raises
    ------
    NotTestableError
        The set lacks data that an effect of the model needs.
    MeasurementError
        The folder cannot be read.
    """
    model, data = model_of(model), set_of(measurement)
    observations = model.observations(data)
    result = _explain(
        model.content,
        observations,
        model.known(),
        data.label,
        matters_counts=matters_counts,
    )
    grown = model.grown(result.model, data)
    sizes = numbered([(cause.entry.name, cause.size_arcsec) for cause in result.causes])
    verdict = _diagnosis(result.verdict, grown, _warnings(data, model, observations))
    return Explanation(grown, sizes, verdict, result)
