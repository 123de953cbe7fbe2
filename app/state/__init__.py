"""Settings and their consequences: cameras, figures, undo, plot geometry. No GUI."""
