"""The stability atlas: every method of the program against the sweep that breaks it."""
