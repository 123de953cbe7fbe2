"""Errors that the command line reports to a user."""


class UsageError(ValueError):
    """Invalid request of a user; the message says what to do."""
