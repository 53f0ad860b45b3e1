"""Methods of calibrating a rotary table, on one simulated table, with one time of measurement.

The methods are those of the paper's introduction, one file each. ``world`` is the table and the
instruments, ``compare`` runs the methods and scores them against the true angle, ``head_places``
says what further read heads bring.
"""
