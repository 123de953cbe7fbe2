"""Errors that the command line reports to a user."""


class UsageError(ValueError):
    """What was asked for cannot be; the message says what to do."""
