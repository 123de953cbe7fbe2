"""Analyses of the lens of the settings as plain figures: what is computed, and what is shown of it. No window."""
