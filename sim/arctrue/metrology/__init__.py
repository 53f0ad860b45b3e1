"""Computes figures, uncertainty budgets, certificates and controllers' correction tables for
metrologists and machine builders."""
