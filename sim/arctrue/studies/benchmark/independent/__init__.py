"""A second generator of benchmark sets, written from the physics only.

Its author has read neither the effects of the workbench nor the first generator (``arctrue.table``
and ``arctrue.studies.simulate``), and it imports neither. Every file in ``worlds`` is one world;
``independent_set`` of ``sets`` makes a set from the world, the content and a seed.
"""
