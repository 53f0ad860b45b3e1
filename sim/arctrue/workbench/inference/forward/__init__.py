"""Searches the residuals of a dense channel for regular lines, steps and slow changes.

:mod:`record` averages these residuals; :mod:`search` adds one line after another;
:mod:`tests_of_a_line` contains the tests that a line must pass; :mod:`events` searches for single
events.
"""
