"""Shows where a model fails: residuals against every condition, ranked in words and drawn."""
