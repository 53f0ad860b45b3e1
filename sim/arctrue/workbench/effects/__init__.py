"""Contains the physical effects, one file each; :mod:`arctrue.workbench.effects.registry` finds
them."""
