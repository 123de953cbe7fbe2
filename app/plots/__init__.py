"""Every plot as a value: curves, points and marks with their numbers. No window."""
