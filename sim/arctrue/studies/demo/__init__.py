"""Runs the whole loop at once: simulated table, gateware in GHDL, calibration, corrected edges."""
