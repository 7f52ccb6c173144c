"""The machinery of long computations: slots, schedule, saving, resuming, stopping."""
