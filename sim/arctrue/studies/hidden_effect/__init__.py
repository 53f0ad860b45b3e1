"""Simulates how the gateware measures a table with a hidden effect, and how the workbench names and
corrects the effect."""
