"""Camera models, one a file."""
