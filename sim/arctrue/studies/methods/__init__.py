"""Methods of calibrating a rotary table, on one simulated table, with one time of measurement.

One file a method. ``world`` is the table and the instruments, ``compare`` runs the methods and
scores what the table then shows against the true angle.
"""
