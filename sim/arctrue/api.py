"""ArcTrue from Python and notebooks: ``import arctrue as at``.

``at.read_set``, ``at.compare``, ``at.diagnose``, ``at.simulate`` and ``at.Model`` do what the
commands of the same names do. Results are dataclasses that a notebook shows as tables; ``plot()``
gives the pictures that the commands write with ``--out``. Docs: docs/python.md.
"""

from __future__ import annotations

import base64
import html
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from arctrue.measurement import MeasurementSet, read_measurement_set
from arctrue.report.charts.chart import Chart
from arctrue.studies.simulate.experiment import EXPERIMENTS
from arctrue.studies.simulate.simulated_set import Wanted, simulate_set
from arctrue.workbench.compare.comparison import ModelComparison
from arctrue.workbench.compare.comparison import compare as _compare
from arctrue.workbench.diagnose.diagnosis import MATTERS_COUNTS
from arctrue.workbench.diagnose.diagnosis import Diagnosis as _Diagnosis
from arctrue.workbench.diagnose.diagnosis import diagnose as _diagnose
from arctrue.workbench.diagnose.report import diagnosis_data, sentences
from arctrue.workbench.effects.base import Effect
from arctrue.workbench.effects.registry import catalogue
from arctrue.workbench.inference.solution import Solution
from arctrue.workbench.model import HistoryStep, default_model
from arctrue.workbench.model import Model as _Model
from arctrue.workbench.model.growth import add_effect, as_stored, fitted, settle
from arctrue.workbench.model.model_file import read_model, write_model
from arctrue.workbench.observations import Observations
from arctrue.workbench.observations.build import observations_of

__all__ = [
    "Comparison",
    "Diagnosis",
    "Model",
    "Pictures",
    "compare",
    "diagnose",
    "read_set",
    "simulate",
]


def read_set(folder: Path | str) -> MeasurementSet:
    """The measurement set of a folder. Raises MeasurementError naming file, row and column."""
    return read_measurement_set(folder)


SetOrFolder = MeasurementSet | Path | str
"""A measurement set, or the name of its folder."""


def _set_of(measurement: SetOrFolder) -> MeasurementSet:
    """The set itself. Raises MeasurementError for a folder, TypeError for what is neither."""
    if isinstance(measurement, MeasurementSet):
        return measurement
    if isinstance(measurement, Path | str):
        return read_set(measurement)
    raise TypeError(
        "expected a measurement set (read_set, simulate) or the name of its folder, found "
        f"{type(measurement).__name__}"
    )


def simulate(
    *effects: str,
    sizes: Sequence[float] = (),
    experiment: str = "short",
    seed: int = 1,
) -> MeasurementSet:
    """A set of a simulated table with the causes ``effects`` (``arctrue simulate --list``).

    ``sizes``: in the order and unit of the effects; drawn where there is none. ``experiment``:
    ``full``, ``short`` or ``lean``. Raises ValueError for an unknown name.
    """
    if experiment not in EXPERIMENTS:
        raise ValueError(f"experiment {experiment!r}: expected {', '.join(sorted(EXPERIMENTS))}")
    padded: list[float | None] = [*sizes, *[None] * (len(effects) - len(sizes))]
    wanted = [Wanted(name, size) for name, size in zip(effects, padded, strict=True)]
    return simulate_set(wanted, EXPERIMENTS[experiment](), seed).measurement


@dataclass(frozen=True)
class Pictures:
    """PNG pictures by file name; a notebook shows them."""

    images: dict[str, bytes]

    def save(self, folder: Path | str) -> list[Path]:
        """Write them to ``folder``."""
        from arctrue.base.whole_file import whole_file

        paths = [Path(folder) / name for name in self.images]
        for path in paths:
            with whole_file(path) as unfinished:
                unfinished.write_bytes(self.images[path.name])
        return paths

    def _repr_html_(self) -> str:
        return "".join(
            f'<img alt="{html.escape(name)}" src="data:image/png;base64,'
            f'{base64.b64encode(image).decode("ascii")}">'
            for name, image in self.images.items()
        )


def _pictures(charts: Mapping[str, Chart]) -> Pictures:
    """Each chart as the PNG file of its name."""
    from arctrue.report.charts.matplotlib_chart import save_charts

    with tempfile.TemporaryDirectory() as folder:
        paths = save_charts(charts, Path(folder))
        return Pictures({path.name: path.read_bytes() for path in paths})


def _table(headings: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    def row(cells: Iterable[object], tag: str) -> str:
        return "<tr>" + "".join(f"<{tag}>{html.escape(str(c))}</{tag}>" for c in cells) + "</tr>"

    return (
        "<table>" + row(headings, "th") + "".join(row(cells, "td") for cells in rows) + "</table>"
    )


@dataclass(frozen=True)
class Model:
    """The effects that a table is known to have; a change gives another model.

    Without ``content``: the paper's, ``graduation_harmonics`` of the orders 1 to 20. ``folders``:
    of own effects.
    """

    content: _Model = field(default_factory=default_model)
    folders: tuple[Path, ...] = ()

    @classmethod
    def read(cls, file: Path | str) -> Model:
        """The model of a file. Raises ModelFileError."""
        content = read_model(Path(file))
        return cls(content, tuple(Path(file).parent / folder for folder in content.folders))

    def write(self, file: Path | str) -> None:
        """Write the model file. Raises OSError."""
        write_model(Path(file), self.content)

    @property
    def effects(self) -> list[str]:
        """Names of the effects."""
        return self.content.names()

    @property
    def history(self) -> list[HistoryStep]:
        """How the error fell, step by step."""
        return list(self.content.history)

    def add(self, effect: str, measurement: SetOrFolder, **settings: object) -> Model:
        """This model with ``effect``, fitted to ``measurement``: a set, or its folder's name.

        Raises EffectNotFoundError, NotTestableError for a set that lacks what the effect needs,
        MeasurementError for a folder that cannot be read.
        """
        measurement = _set_of(measurement)
        content, _ = add_effect(
            self.content,
            effect,
            settings,
            self.observations(measurement),
            self.known(),
            measurement.title,
        )
        return Model(content, self.folders)

    def known(self) -> dict[str, type[Effect]]:
        """All effects by name, own ones with them."""
        return catalogue(list(self.folders))

    def observations(self, measurement: SetOrFolder) -> Observations:
        """The rows of a set (or of its folder) with their conditions, as this model sees them."""
        return observations_of(
            _set_of(measurement), reference_temperature_c=self.content.reference_temperature_c
        )

    def plot(self) -> Pictures:
        """How the error fell. Raises ValueError for a model without a history."""
        if not self.content.history:
            raise ValueError("the model has no history yet; add an effect first")
        from arctrue.report.charts.ladder import ladder

        return _pictures({"history": ladder(self.content.history)})

    def _repr_html_(self) -> str:
        rows = [
            (step.action, step.effect, channel, f"{rms:.4f}", f"{step.peak_arcsec[channel]:.3f}")
            for step in self.content.history
            for channel, rms in step.rms_arcsec.items()
        ]
        said = f"<p>Model: {html.escape(', '.join(self.effects))}</p>"
        return said + (
            _table(("step", "effect", "channel", "RMS ″", "peak ″"), rows) if rows else ""
        )


@dataclass(frozen=True)
class Comparison:
    """Where a model fails: ``data`` has channels and findings; arcseconds."""

    data: dict[str, Any]
    result: ModelComparison = field(repr=False)
    solution: Solution = field(repr=False)

    def plot(self) -> Pictures:
        """The residual by branches and its maps."""
        from arctrue.report.charts.comparison_charts import comparison_charts

        return _pictures(comparison_charts(self.solution, self.result))

    def _repr_html_(self) -> str:
        rows = [
            (name, item.rows, f"{item.rms_arcsec:.4f}", f"{item.peak_arcsec:.3f}",
             f"{item.noise_arcsec:.4f}", f"{item.lack_of_fit_p:.2g}")
            for name, item in self.result.channels.items()
        ]  # fmt: skip
        headings = ("channel", "rows", "RMS ″", "peak ″", "noise of repeats ″", "lack of fit p")
        found = "".join(f"<li>{html.escape(item.text)}</li>" for item in self.result.findings)
        return _table(headings, rows) + f"<ul>{found}</ul>"


@dataclass(frozen=True)
class Diagnosis:
    """Which effect is missing: ``data`` is what ``diagnose --json`` writes."""

    verdict: str
    sentences: tuple[str, ...]
    data: dict[str, Any] = field(repr=False)
    result: _Diagnosis = field(repr=False)

    def plot(self) -> Pictures:
        """The evidence for each candidate. Raises ValueError where the data are faulty."""
        if self.result.base is None:
            raise ValueError(f"nothing was fitted: the verdict is {self.verdict}")
        from arctrue.report.charts.candidates import candidates_chart

        return _pictures({"candidates": candidates_chart(self.result)})

    def _repr_html_(self) -> str:
        said = "".join(f"<p>{html.escape(text)}</p>" for text in self.sentences)
        return f"<p><b>Verdict: {html.escape(self.verdict)}</b></p>{said}"


def compare(
    measurement: SetOrFolder, model: Model | None = None, *, fit: bool = True, seed: int = 1
) -> Comparison:
    """How far a model is from a set, and where; ``fit=False`` judges the stored coefficients.

    ``measurement``: the set, or the name of its folder. Raises NotTestableError for a model that
    the set cannot test, MeasurementError for a folder that cannot be read.
    """
    model = Model() if model is None else model
    observations = model.observations(measurement)
    if fit:
        _, solution = fitted(model.content, observations, model.known())
    else:
        solution = as_stored(model.content, observations, model.known())
    result = _compare(solution, seed)
    data = {
        "channels": {name: asdict(item) for name, item in result.channels.items()},
        "findings": [asdict(item) for item in result.findings],
    }
    return Comparison(data, result, solution)


def diagnose(
    measurement: SetOrFolder,
    model: Model | None = None,
    *,
    matters_counts: float = MATTERS_COUNTS,
) -> Diagnosis:
    """Which physical effect the model lacks, or that the set cannot tell.

    ``measurement``: the set, or the name of its folder. Raises MeasurementError for a folder that
    cannot be read.
    """
    model = Model() if model is None else model
    observations = model.observations(measurement)
    known = model.known()
    terms = settle(model.content, observations, known)
    result = _diagnose(observations, terms, known, matters_counts=matters_counts)
    return Diagnosis(
        result.verdict, tuple(sentences(result)), diagnosis_data(result, model.effects), result
    )
