"""GLSL of the viewer."""
