"""Theme, dials and other controls for imgui."""
