"""The page of ``arctrue serve``: it shows a set, a model and the missing effect in a browser.

The server stores each state of a model as a numbered step in a folder (``session``). The address of
a page names a step, so that the browser's Back undoes a change, and two tabs do not interfere. Work
that takes longer than a click runs in its own process (``jobs``, ``ranking_job``).
"""
