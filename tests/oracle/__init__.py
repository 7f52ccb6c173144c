"""The oracle: one episode in plain scalar loops, written from docs/model.md; the fast path must match it step by step.

It knows the paper's parts only and is no part of the installed package.
"""
