"""Keeps the earlier name of :mod:`arctrue.workbench.inference.design_matrix` for one release."""

from arctrue.workbench.inference.design_matrix import BLOCK_ROWS, Term, channel_columns, row_blocks

__all__ = ["BLOCK_ROWS", "Term", "channel_columns", "row_blocks"]
