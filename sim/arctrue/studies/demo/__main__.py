"""``python -m arctrue.studies.demo``: the same as ``arctrue demo``."""

from arctrue.cli.demo import demo

demo()
