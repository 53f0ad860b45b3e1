"""The benchmark of the diagnosis: sets whose truth is hidden, compared with an ideal test.

``make`` draws the seeds of the sets, ``run`` makes and diagnoses each set, ``score`` compares the
answers with truth and oracle, ``page`` writes the results. Answers of other programs can be scored
too.
"""
