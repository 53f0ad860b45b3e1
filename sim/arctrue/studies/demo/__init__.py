"""Runs the whole chain at once: simulated table, gateware in GHDL, calibration, corrected edges."""
