"""A table with a hidden effect, measured by the gateware, named by the workbench, corrected."""
