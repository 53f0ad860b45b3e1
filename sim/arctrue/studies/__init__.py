"""Contains the studies: each study measures a simulated table and evaluates the project's result
for this table.

A study takes settings, runs, and returns a result that ``report`` can draw. Studies import the
simulated table, gateware, firmware and workbench; none of these four imports a study.
"""
