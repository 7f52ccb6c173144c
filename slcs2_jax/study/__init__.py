"""What run folders say: collected, compared, drawn, and held against the paper's claims. Reads folders only; no JAX.

Needs the extra `analysis` (SciPy, statsmodels, tabulate); the figures need the extra `plot` (matplotlib).
"""
