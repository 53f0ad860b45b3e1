"""Offers ArcTrue to Python programs and notebooks: ``import arctrue as at``.

A function with the name of a command does the same as this command. Results are dataclasses that a
notebook shows as tables; ``plot()`` gives the pictures that the commands write with ``--out``.
docs/python.md describes the functions.
"""

from arctrue.api.dataset import Dataset
from arctrue.api.estimator import FitEstimator
from arctrue.api.fit import fit
from arctrue.api.fit_result import FitResult
from arctrue.api.model import Model, add, drop
from arctrue.api.parameters import FitParameter, FitParameters
from arctrue.api.pictures import Pictures
from arctrue.api.results import (
    Comparison,
    Diagnosis,
    Explanation,
    compare,
    diagnose,
    explain,
)
from arctrue.api.sets import read_set, simulate, write_set
from arctrue.api.transfer import ExportRefusedError, export, import_files
from arctrue.api.two_models import ModelTest, compare_models

__all__ = [
    "Comparison",
    "Dataset",
    "Diagnosis",
    "Explanation",
    "ExportRefusedError",
    "FitEstimator",
    "FitParameter",
    "FitParameters",
    "FitResult",
    "Model",
    "ModelTest",
    "Pictures",
    "add",
    "compare",
    "compare_models",
    "diagnose",
    "drop",
    "explain",
    "export",
    "fit",
    "import_files",
    "read_set",
    "simulate",
    "write_set",
]
