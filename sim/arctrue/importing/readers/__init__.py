"""The readers of this package, one file a format; pyproject.toml registers them."""
