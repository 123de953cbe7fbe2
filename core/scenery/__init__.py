"""What a picture is taken of: objects, light and the built-in scenes."""
