"""What the project raises when something it was given cannot be used, or cannot be stored."""


class InputError(ValueError):
    """Bad input from a person: the message is one line naming the field, its value and what is accepted."""


class StorageError(OSError):
    """A file could not be written or read, through no fault of what was asked: one line naming it and what to do."""
