"""Bit-true models of the gateware: numpy integers, one module an entity, same names."""
