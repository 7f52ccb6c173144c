"""The tests, a package so that benchmarks find the oracle in it."""
