"""Measures how often the diagnosis is right, on measurement sets with hidden causes; an ideal test
(the oracle) gives the limit of detectability.

``make`` draws the seeds of the sets, ``run`` makes and diagnoses each set, ``score`` compares the
answers with the hidden causes and the oracle, ``page`` writes the results. Answers of other
programs can be scored too.
"""
