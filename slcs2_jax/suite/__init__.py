"""A benchmark with frozen worlds, a protocol, and entries of several fields (docs/suite.md).

Reading the suite, its results and its table starts no JAX; training, evaluating and replaying do.
"""
