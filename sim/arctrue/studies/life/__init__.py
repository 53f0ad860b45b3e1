"""Tests the forecast of ``arctrue life`` on simulated lives of tables, for which the day on which
the effect exceeds its limit is known."""
