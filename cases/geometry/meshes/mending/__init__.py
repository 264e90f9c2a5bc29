"""Steps of a repair: what joins what, welding, doubled triangles, halved edges, orientation."""
