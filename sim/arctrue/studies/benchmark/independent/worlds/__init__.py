"""Each file is one world: its docstring says what is measured, ``draw`` makes the scene.

``draw(random, hidden, rows)`` returns a Scene; a world that does not have both contents,
``nothing`` and ``hidden``, defines ``CONTENTS``.
"""
