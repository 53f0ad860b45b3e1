"""Tests of the scripts and of what the Makefile calls."""
