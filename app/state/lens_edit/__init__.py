"""The edited lens of the settings: its document, its cells as text, the handles of its section. No GUI."""
