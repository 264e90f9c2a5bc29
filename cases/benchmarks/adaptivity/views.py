"""Tables of the model adaptivity's benchmark."""

from ..view import View

VIEWS = {
    "thesis": View(
        r"Re = 10, h = 1/(?P<n>\d+), counting, step (?P<k>\d+)",
        {
            "step": "{k}",
            "-estimate": "{thesis_eps:.3e}",
            "printed": "{printed:.3g}",
            "fraction": "{elements:.3f}",
            "printed fraction": "{printed elements:.3f}",
            "effectivity": "{effectivity:.3f}",
            "seconds": "{seconds:.2g}",
        },
    ),
    "first": View(
        r"Re = 1000, (?P<mesh>[^,]+), step 0",
        {
            "mesh": "{mesh}",
            "-estimate": "{thesis_eps:.3f}",
            "to the printed one": "{error:.1e}",
            "unknowns": "{unknowns}",
            "seconds": "{seconds:.2g}",
        },
    ),
    "loops": View(
        r"(?P<what>.+): whole loop",
        {
            "loop": "{what}",
            "steps": "{steps}",
            "result": "{result}",
            "error": "{error:.0e}",
            "seconds": "{seconds:.3g}",
            "peak MB": "{peak_MB:.0f}",
        },
    ),
    "linearised": View(
        r"linearised, h = 1/(?P<n>\d+)",
        {"mesh": "h = 1/{n}", "largest effectivity - 1": "{error:.0e}", "steps": "{steps}"},
    ),
    "meshes": View(
        r"(?P<re>Re = \d+), h = 1/(?P<n>\d+), mesh independence",
        {
            "": "{re}",
            "mesh": "h = 1/{n}",
            "first estimate": "{estimate:.3g}",
            "error then": "{error:.3g}",
            "Navier-Stokes elements for 1e-2, 1e-4, 1e-6": (
                "{elements for 0.01:.2f}, {elements for 0.0001:.2f}, {elements for 1e-06:.2f}"
            ),
        },
    ),
    "partitions": View(
        r"S = (?P<part>[^,]+), (?P<scheme>[a-z_]+), (?P<relaxation>[^,]+)",
        {"Stokes part": "{part}", "stress": "{stress}", "transmission": "{scheme}"},
        ("{relaxation}: passes, difference", "{passes}, {error:.0e}"),
    ),
    "boundary": View(
        r"S = (?P<part>.+), h = 1/(?P<n>\d+), boundary elements",
        {
            "Stokes part": "{part}",
            "mesh": "h = 1/{n}",
            "difference": "{error:.1e}",
            "finite elements to h/2": "{finite elements to h/2:.1e}",
            "boundary elements to h/2": "{boundary elements to h/2:.1e}",
            "seconds": "{seconds:.2g}",
            "over finite elements": "{ratio:.2g}",
        },
    ),
    "boundary_loops": View(
        r"boundary elements, (?P<adjoint>\w+) adjoint, h = 1/\d+, step (?P<k>\d+)",
        {"adjoint": "{adjoint}"},
        ("step {k}: error, effectivity", "{error:.1e}, {effectivity:.2f}"),
    ),
    "costs": View(
        r"(?P<re>Re = \d+), h = 1/\d+, (?P<how>(?!.*(?:step|loop|independence)).+)",
        {"": "{how}"},
        (
            "{re}: error, fraction, seconds over Navier-Stokes",
            "{error:.0e}, {elements:.2f}, {ratio:.2f}",
        ),
    ),
}
