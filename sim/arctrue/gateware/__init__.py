"""Models the gateware bit by bit with numpy integers; each module models the entity of the same
name."""
