"""Forward search for regular lines, steps and slow changes in a dense record.

:mod:`record` averages what a model leaves of one channel; :mod:`search` adds one line after the
other; :mod:`tests_of_a_line` holds what a line has to pass; :mod:`events` looks for what happens
once.
"""
