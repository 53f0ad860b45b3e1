"""Measurement sets from a table of exact geometry, with physical causes whose truth is known."""
