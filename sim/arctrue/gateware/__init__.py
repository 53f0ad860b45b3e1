"""Models the gateware bit by bit with numpy integers; a module with the name of an entity models
this entity, and the other modules define words, files and register accesses."""
