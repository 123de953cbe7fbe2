"""The rendered picture, its toolbar, menu, overlays and comparison."""
