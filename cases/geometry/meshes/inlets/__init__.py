"""The inlet of a user's mesh: chosen triangles or a capped hole, checks, rim and inflow."""
