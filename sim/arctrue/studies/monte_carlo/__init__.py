"""Coverage of the uncertainty that the calibration states, over random tables.

Each trial draws a table and all input quantities, measures, calibrates and compares with the truth.
"""
