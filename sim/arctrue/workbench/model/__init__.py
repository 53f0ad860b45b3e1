"""A model: the effects that it has, what the fit found for them, and how it grew."""

from arctrue.workbench.model.model import HistoryStep, Model, ModelEffect, ModelTable, default_model

__all__ = ["HistoryStep", "Model", "ModelEffect", "ModelTable", "default_model"]
