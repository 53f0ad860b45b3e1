"""The page of ``arctrue serve``: shows a set, a model and the missing effect in a browser.

The server stores each state of a model as a numbered step in a folder (``session``). An address
names a step, so that back and undo are those of the browser, and two tabs do not interfere. Work
that takes longer than a click runs in its own process (``jobs``, ``ranking_job``).
"""
