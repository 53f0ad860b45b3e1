"""Coverage of the uncertainty that the calibration states, over random tables.

Each trial draws a table and all input quantities, measures the table, calibrates it, and compares
the result with the truth.
"""
