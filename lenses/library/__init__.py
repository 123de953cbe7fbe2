"""The lens library: designs with their headers, search and filters."""
