"""The window, its panels and workers, export and the command line."""
