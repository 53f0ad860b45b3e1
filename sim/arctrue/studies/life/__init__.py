"""Tests the forecast of ``arctrue life`` on simulated lives of tables with a known day on which the
effect exceeds its limit."""
