"""Implements the page of ``arctrue serve``, which shows a measurement set, a model and the missing
effect in a browser.

The server stores each state of a model as a numbered step in a folder (``session``). The address of
a page names a step, so that the browser's Back undoes a change, and two tabs do not interfere. A
ranking, which takes longer than a click, runs in its own process (``jobs``, ``ranking_job``).
"""
