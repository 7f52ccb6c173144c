"""How fast the simulator is: throughput, scaling and whole searches. Run from the repository's root."""
