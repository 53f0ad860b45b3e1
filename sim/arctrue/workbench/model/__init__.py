"""Contains the model: its effects, their fitted values, and its history."""

from arctrue.workbench.model.model import HistoryStep, Model, ModelEffect, ModelTable, default_model

__all__ = ["HistoryStep", "Model", "ModelEffect", "ModelTable", "default_model"]
