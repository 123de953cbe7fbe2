"""Parts of scene files: the values of their tables, and the files that they name, all in the folder of the scene."""
