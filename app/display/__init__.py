"""OpenGL textures and the presentation of render updates. No imgui."""
