"""Shipped scenes, one TOML file each; `cases.loader` finds them here."""
