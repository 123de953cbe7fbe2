"""The panels of the window: one file or folder each."""
