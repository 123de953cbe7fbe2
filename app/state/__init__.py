"""Settings and what follows from them: cameras, figures, undo, plot geometry. No GUI."""
