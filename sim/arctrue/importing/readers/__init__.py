"""Contains the readers of this package, one file per format; pyproject.toml registers them."""
