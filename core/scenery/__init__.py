"""The scene: its objects, their intersection and shading stages, and the built-in scenes."""
