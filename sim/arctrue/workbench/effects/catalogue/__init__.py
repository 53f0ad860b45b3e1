"""Contains the built-in physical effects, one file each; the registry finds an effect by its
file."""
