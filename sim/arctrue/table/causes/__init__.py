"""Contains the physical causes of a wrong reading, one in each file; the registry imports every
file here."""
