"""Physical effects, one file each; :mod:`arctrue.effects.registry` finds them."""
