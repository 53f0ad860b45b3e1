"""Studies: each builds a simulated table, measures it, and judges what the project makes of it.

A study takes settings, runs, and gives a result that ``report`` can draw. Studies bring the
simulated table, gateware, firmware and workbench together; none of these imports a study.
"""
