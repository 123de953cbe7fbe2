"""The lens browser: search, filters, and the grid of thumbnails."""
