"""Lenses that a person edits: a document, edits of it, its solves and pickups, pasted tables, and its faults."""
