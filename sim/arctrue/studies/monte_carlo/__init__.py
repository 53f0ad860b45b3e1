"""Measures, over random tables, the coverage of the uncertainty that the calibration states.

Each trial draws a table and all input quantities, measures the table, calibrates it, and compares
the result with the truth.
"""
