"""Makes figures, budgets, certificates and controllers' tables for metrologists and machine
builders."""
