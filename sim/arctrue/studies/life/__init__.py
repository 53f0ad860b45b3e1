"""Tests the forecast of ``arctrue life`` on simulated lives, whose day of the limit is known."""
