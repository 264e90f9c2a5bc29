"""Users' meshes: what a file holds, its repairs, and the way to a bag of Bezier triangles."""
