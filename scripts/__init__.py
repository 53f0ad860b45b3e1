"""Contains the programs that the Makefile's targets run."""
