"""Files that scene files name: pictures of the sky, and the folder outside of which nothing is read."""
