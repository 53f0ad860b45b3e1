"""One file a world: its docstring says what is measured, ``draw`` makes the scene.

``draw(random, hidden, rows)`` gives a Scene; ``CONTENTS`` stands where a world has not both
contents, ``nothing`` and ``hidden``.
"""
