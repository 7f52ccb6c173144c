"""python -m slcs2_jax"""

from slcs2_jax.cli import main

if __name__ == "__main__":
    raise SystemExit(main())
