"""Tables of the benchmark of raw meshes."""

from ..view import View

VIEWS = {
    "plates": View(
        r"plate, degree (?P<p>\d), \d+ triangles",
        {
            "degree": "{p}",
            "triangles": "{triangles}",
            "coefficients": "{coefficients}",
            "vertices with six neighbours": "{regular vertices:.0%}",
            "H2 error": "{error:.1e}",
            "rate": "{rate}",
            "L2 error": "{L2 error:.1e}",
            "seconds": "{seconds:.2g}",
        },
    ),
    "roofs": View(
        r"roof, degree (?P<p>\d), \d+ triangles",
        {
            "degree": "{p}",
            "triangles": "{triangles}",
            "deflection": "{deflection}",
            "error": "{error:.1e}",
            "seconds": "{seconds:.2g}",
        },
    ),
    "locking": View(
        r"thin roof, h=[\d.]+, \d+ triangles",
        {"h/R": "{thickness/radius:g}"},
        ("{triangles} triangles", "{deflection/reference:.4f}"),
    ),
    "rotations": View(
        r"end shear, degree (?P<p>\d), \d+ triangles",
        {
            "degree": "{p}",
            "triangles": "{triangles}",
            "against": "{reference}",
            "error": "{error:.1e}",
            "at the end": "{value}",
            "Newton iterations": "{newton}",
            "seconds": "{seconds:.2g}",
        },
    ),
    "spheres": View(
        r"inflated sphere, degree (?P<p>\d), \d+ triangles",
        {
            "degree": "{p}",
            "triangles": "{triangles}",
            "error of the stretch": "{error:.1e}",
            "Newton iterations": "{iterations}",
            "seconds": "{seconds:.2g}",
        },
    ),
    "modes": View(
        r"six zero modes, degree (?P<p>\d), (?P<n>\d+) triangles",
        {
            "degree": "{p}",
            "triangles": "{n}",
            "largest of six": "{error:.0e}",
            "seventh": "{seventh:.1e}",
            "energy of a rigid motion": "{rigid motion:.0e}",
        },
    ),
    "speed": View(
        r"speed, (?P<what>.+)",
        {"": "{what}", "us an element": "{us/element:.3g}", "times a quad": "{times a quad:.2g}"},
    ),
    "strain": View(
        r"raw sphere, strain, (?P<geometry>[a-z ]+), density (?P<q>\d), \d+ triangles",
        {
            "geometry": "{geometry}",
            "density": "{q}",
            "triangles": "{triangles}",
            "error": "{error:.1e}",
            "over the best": "{error/best:.2f}",
            "drag": "{drag:.0e}",
            "estimate over error": "{estimate/error:.2f}",
            "seconds": "{seconds:.2g}",
        },
    ),
    "own": View(
        r"raw sphere against density 5, (?P<geometry>[a-z ]+), density 2",
        {
            "geometry": "{geometry}",
            "error": "{error:.1e}",
            "over the best": "{error/best:.2f}",
            "own normals off by": "{reference - (2 E n + 3 E x):.1e}",
        },
    ),
    "inside": View(
        r"(?P<body>.+), flow inside, (?P<geometry>[a-z ]+), density (?P<q>\d)",
        {
            "body": "{body}",
            "geometry": "{geometry}",
            "density": "{q}",
            "triangles": "{triangles}",
            "error": "{error:.1e}",
            "over the best": "{error/best:.2f}",
            "seconds": "{seconds:.2g}",
        },
    ),
    "drops": View(
        r"raw sphere, strain, .+, viscosity ratio (?P<ratio>[\d.]+)",
        {
            "viscosity ratio": "{ratio}",
            "triangles": "{triangles}",
            "error": "{error:.1e}",
            "over the best": "{error/best:.2f}",
            "Gauss identity": "{Gauss identity:.0e}",
        },
    ),
    "thin": View(
        r"raw ellipsoid c/a (?P<c>[\d.]+), moving, \d+ triangles",
        {
            "c/a": "{c}",
            "triangles": "{triangles}",
            "error": "{error:.1e}",
            "over the best": "{error/best:.2f}",
            "drag": "{drag:.0e}",
            "quadrature": "{quadrature:.0e}",
            "estimate over error": "{estimate/error:.2f}",
        },
    ),
    "flows": View(
        r"(?P<what>filling .+|raw torus, drag, .+)",
        {"": "{what}", "triangles": "{triangles}", "error": "{error:.0e}"},
    ),
    "large": View(
        r"large raw sphere, .+",
        {
            "unknowns": "{unknowns}",
            "error of the drag": "{error:.0e}",
            "checks, build, solve (s)": "{checks s:.0f}, {build s:.0f}, {solve s:.0f}",
            "all, one thread expected (s)": "{seconds:.0f}, {seconds expected:.0f}",
            "operator, expected (GB)": "{operator GB:.2g}, {GB expected:.2g}",
        },
    ),
    "bag": View(
        r"pancake from STL, (?P<at>.+)",
        {
            "": "{at}",
            "pressure off by": "{error:.1e}",
            "height off by": "{height error:.1e}",
            "rejected": "{rejected}",
            "assemblies a step": "{assemblies/step:.2f}",
            "zeta over velocity": "{zeta:.0e}",
            "times the splines' seconds": "{ratio:.2g}",
        },
    ),
}
