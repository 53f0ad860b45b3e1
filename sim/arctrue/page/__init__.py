"""The page of ``arctrue serve``: a set, a model and what is missing, in a browser.

The server keeps every state of a model as a numbered step in a folder (``session``); an address
names a step, so that back and undo are the browser's own and two tabs do not meet. What takes
longer than a click runs as a process of its own (``jobs``, ``ranking_job``).
"""
