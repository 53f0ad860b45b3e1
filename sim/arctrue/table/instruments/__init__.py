"""Simulates the reference instruments that measure the table: a polygon on the table and an
autocollimator."""

from arctrue.table.instruments.autocollimator import Autocollimator
from arctrue.table.instruments.polygon import Polygon

__all__ = ["Autocollimator", "Polygon"]
