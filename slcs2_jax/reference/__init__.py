"""One episode in plain scalar loops, written from the specification: what the fast path must match, phase by phase."""
