"""The benchmark of the diagnosis: sets whose truth is hidden, judged beside an ideal test.

``make`` draws the sets' seeds, ``run`` makes and diagnoses each, ``score`` compares the answers
with truth and oracle, ``page`` writes what came out. Anybody's answers can be scored.
"""
