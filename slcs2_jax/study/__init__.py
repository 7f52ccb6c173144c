"""What run folders say: collected, compared, drawn, and held against the paper's claims. No JAX, but where the
calibration study computes its points.

Needs the extra `analysis` (SciPy, statsmodels, tabulate); the figures need the extra `plot` (matplotlib).
"""
