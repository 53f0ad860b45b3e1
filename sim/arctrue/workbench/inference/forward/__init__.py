"""Forward search for regular lines, steps and slow changes in a dense record.

:mod:`record` averages the residual of one channel; :mod:`search` adds one line after another;
:mod:`tests_of_a_line` contains the tests that a line must pass; :mod:`events` searches for single
events.
"""
