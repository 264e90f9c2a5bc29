"""Steps of a repair: what joins what, welding, doubled triangles, bisected edges, orientation."""
