"""The native chunk: many time-steps of many episodes in one call of C++ on CPUs, bit for bit the same on every machine.

``choice`` says whether it computes a batch, ``advance`` calls it, ``library`` finds or compiles it. The JAX step
remains the definition of the model; what the native chunk does not know, XLA computes.
"""
