"""The world that does not move: scenarios, geometry and the radio."""
