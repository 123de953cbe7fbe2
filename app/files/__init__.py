"""Reading and writing of what a user keeps: pictures, settings, light fields."""
