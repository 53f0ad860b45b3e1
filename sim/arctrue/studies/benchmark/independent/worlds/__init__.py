"""Contains one file for each world: the file's docstring describes the measurement, its function
``draw`` makes the scene.

``draw(random, hidden, rows)`` returns a Scene; a world that does not have both contents,
``nothing`` and ``hidden``, defines ``CONTENTS``.
"""
