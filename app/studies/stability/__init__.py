"""The stability atlas: every method of the program against the stress that breaks it."""
