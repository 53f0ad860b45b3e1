"""Bit-true models of the gateware: numpy integers, one module per entity, same names."""
