"""Tests of the scripts and of the commands of the Makefile."""
