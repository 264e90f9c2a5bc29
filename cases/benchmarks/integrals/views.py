"""Tables of the boundary integrals' benchmark."""

from ..view import View

DEFAULT = {"orders": "default"}
NEAR = "{error:.1e} / {points} / {peer_error:.1e}"
VIEWS = {
    "torus": View(
        r"torus shear",
        {"degree": "{degree}", "geometry": "{geometry}"},
        ("n = {n}", "{error:.2e} ({over_best:.3f})"),
    ),
    "torus_rates": View(
        r"torus shear",
        {"degree": "{degree}", "geometry": "{geometry}"},
        ("to n = {n}", "{rate:.2f}"),
    ),
    "sphere": View(
        r"sphere (?P<flow>\w+)",
        {"flow": "{flow}"},
        ("lambda = {viscosity_ratio:g}", "{error:.1e} ({over_best:.3f})"),
    ),
    "gap": View(
        r"thin gap",
        {"half-gap": "{half}"},
        ("mesh {mesh}", "{error:.2e} ({over_best:.3f})"),
    ),
    "orders": View(
        r"orders",
        {"degree": "{degree}", "inner orders": "{inner}"},
        ("{outer} outer points", "{error:.2e} ({seconds:.2g} s)"),
    ),
    "near": View(
        r"near (?P<layer>\w+)",
        {"d/h": "{d/h:.0e}"},
        ("{layer} layer: error / points / Gauss of equal cost", NEAR),
        DEFAULT,
    ),
    "triangles": View(
        r"triangle (?P<layer>\w+)",
        {"d/h": "{d/h:.0e}"},
        (
            "{layer} layer: error / contracted at one vertex",
            "{error:.1e} / {peer_error:.1e}",
        ),
        DEFAULT,
    ),
    "speed": View(
        r"speed (?P<layer>\w+)",
        {"elements": "{elements}", "degree": "{degree}"},
        (
            "{layer} layer: seconds / us a pair / ns a point",
            "{seconds:.2g} / {us_a_pair:.2g} / {ns_a_point:.3g}",
        ),
    ),
    "action": View(
        r"action of K",
        {
            "elements": "{elements}",
            "K, seconds": "{seconds:.2g}",
            "V, seconds": "{peer_seconds:.2g}",
            "K over V": "{ratio:.2f}",
            "defect of the Gauss identity": "{error:.1e}",
        },
    ),
    "corners": View(
        r"collapsed corners",
        {
            "far": "{far}",
            "near": "{near}",
            "polar": "{polar}",
            "seconds": "{seconds:.2g}",
            "change to the finest rule": "{error:.1e}",
        },
    ),
    "rules": View(
        r"rule",
        {"body": "{body}", "thinness": "{thinness}"},
        ("far {far}, near {near}, polar {polar}", "{error:.1e}"),
    ),
    "gmres": View(
        r"gmres (?P<kind>\w+) (?P<body>.+)",
        {"body, gap": "{body}", "unknowns": "{unknowns}"},
        ("{kind}: iterations (seconds)", "{iterations} ({seconds:.2g})"),
    ),
    "squeeze": View(
        r"squeeze film",
        {
            "h/a": "{h/a}",
            "mesh": "{mesh}",
            "force over Reynolds' film": "{force / film:.3f}",
            "seconds": "{seconds:.2g}",
        },
    ),
}
