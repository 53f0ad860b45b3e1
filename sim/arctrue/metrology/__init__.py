"""What a metrologist or a machine builder takes away: figures, budgets, tables for controllers."""
