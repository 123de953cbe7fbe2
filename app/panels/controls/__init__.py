"""The control column: dials and their popups."""
