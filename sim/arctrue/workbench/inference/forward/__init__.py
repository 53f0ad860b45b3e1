"""Searches the residuals of a channel with closely spaced rows for lines, steps and slow changes.

A line is a sinusoid over the angle or over time; its rate is its order (periods per turn) or its
frequency (Hz). A step is a lasting change between two rows.

:mod:`record` averages these residuals; :mod:`search` adds one line after another;
:mod:`tests_of_a_line` contains the tests that a line must pass; :mod:`events` searches for single
events.
"""
