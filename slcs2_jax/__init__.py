"""SLCS2 (arXiv 1910.12412) in JAX. Importing the package does not start JAX."""

__version__ = "0.1.0"
