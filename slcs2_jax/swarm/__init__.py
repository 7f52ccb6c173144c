"""The world in motion: what agents see, where they go, what they send. No rules, no learning, no fitness."""
