"""Implements the page of ``arctrue serve``, which shows a measurement set, a model, and the
physical effects that the model may lack, in a browser.

The server stores each state of a model as a numbered step in a folder; the module ``session`` reads
and writes this folder. The address of a page names a step, so that the browser's Back undoes a
change, and two tabs do not interfere. The ranking compares all effects that the model may lack.
This takes longer than an answer to a click may take, so the ranking runs in its own process
(``jobs``, ``ranking_job``).
"""
