"""Lens tables: the rows, numbers and system data that every format of lens files shares."""
