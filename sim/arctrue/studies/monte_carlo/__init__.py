"""Uncertainty of the whole calibration by the propagation of distributions (GUM supplement 1).

Each trial draws a table and all input quantities, measures, calibrates and compares with the truth.
"""
