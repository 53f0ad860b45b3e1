"""Contains the tests of the scripts, which the Makefile's targets run."""
