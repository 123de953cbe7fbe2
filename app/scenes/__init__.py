"""Scene files and what they name: meshes, textures, skies and photographs. No window."""
