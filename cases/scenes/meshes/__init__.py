"""Mesh files of shipped scenes, and the modules that make them; `make` writes them all."""
