"""Generates benchmark sets a second time, with code that was written from the physics only.

The author of this code has read neither the effects of the workbench nor the first generator
(``arctrue.table`` and ``arctrue.studies.simulate``), and the code imports neither. Every file in
``worlds`` defines one world (one kind of measurement); ``independent_set`` in ``sets`` makes a set
from a world, a content (``nothing`` or ``hidden``) and a seed.
"""
