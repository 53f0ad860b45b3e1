"""Studies: each measures a simulated table and evaluates the result of the project on it.

A study takes settings, runs, and returns a result that ``report`` can draw. Studies combine
simulated table, gateware, firmware and workbench; none of these imports a study.
"""
