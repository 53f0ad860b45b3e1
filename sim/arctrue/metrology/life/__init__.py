"""Tracks the history of one machine: sizes of effects over months, their changes, and the day on
which a limit is passed.

``machine`` fits every set of a folder; ``series`` holds the size of an effect over time; ``change``
finds steps and drifts with a stated rate of false alarms; ``forecast`` gives the day on which a
limit is passed. ``arctrue life`` prints the result of
:func:`arctrue.metrology.life.history.history_of`.
"""
