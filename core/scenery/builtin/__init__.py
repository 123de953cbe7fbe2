"""The scenes that lensbench ships."""
