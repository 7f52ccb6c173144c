"""What the project raises when something it was given cannot be used."""


class InputError(ValueError):
    """Bad input from a person: the message is one line naming the field, its value and what is accepted."""
