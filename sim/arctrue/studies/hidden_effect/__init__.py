"""The gateware measures a table with a hidden effect, the workbench names the effect and corrects
it."""
