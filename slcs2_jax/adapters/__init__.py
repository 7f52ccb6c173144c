"""The environment in the form that others' learners expect. Import the module that is needed; each says what of."""
