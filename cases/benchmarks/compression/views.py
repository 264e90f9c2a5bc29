"""Tables of the compression's benchmark."""

from ..view import View

VIEWS = {
    "points": View(
        r"(?P<cloud>sphere|stack), (?P<method>aca|h2)",
        {
            "cloud": "{cloud}",
            "method": "{method}",
            "N": "{N}",
            "tolerance": "{tolerance:.0e}",
            "achieved": "{error:.1e}",
            "seconds": "{seconds:.2g}",
            "times faster than": "{ratio:.3g}, {peer}",
            "build, in its applications": "{build/peer:.2g}",
            "bytes an unknown": "{bytes/unknown:.0f}",
            "growth from the smallest N": "{growth:.2f}",
            "all threads over one": "{threads ratio:.2f}",
        },
    ),
    "operators": View(
        r"operator (?P<body>.+), (?P<method>\w+)",
        {"body": "{body}", "unknowns": "{unknowns}", "method": "{method}"},
        ("{tolerance:.0e}: kB an unknown (error)", "{kB/unknown:.1f} ({error:.0e})"),
    ),
    "product": View(
        r"far product, .*",
        {
            "elements": "{elements}",
            "seconds": "{seconds:.2g}",
            "direct sums over it": "{ratio:.3g}",
            "achieved": "{error:.1e}",
        },
    ),
    "measured": View(
        r"measured solve, thinness (?P<gap>[^,]+), (?P<flow>\w+)",
        {
            "thinness": "{gap}",
            "flow": "{flow}",
            "unknowns": "{unknowns}",
            "matrix tolerance": "{operator at:.1e}",
            "CPU seconds": "{seconds:.3g}",
            "over the budget's tolerance, unmeasured": "{CPU ratio:.2f}",
            "corrections": "{corrections}",
            "estimated error": "{estimate:.1e}",
            "error": "{error:.1e}",
            "error unmeasured": "{error unmeasured:.1e}",
            "asked": "{tolerance:.0e}",
        },
    ),
    "solves": View(
        r"solve, thinness (?P<gap>[^,]+), (?P<method>.+)",
        {
            "thinness": "{gap}",
            "method": "{method}",
            "unknowns": "{unknowns}",
            "seconds": "{seconds:.3g}",
            "near, compression, preconditioner, GMRES": (
                "{near:.2g}, {build:.2g}, {preconditioner:.2g}, {gmres:.2g}"
            ),
            "iterations": "{iterations}",
            "kB an unknown": "{kB/unknown:.1f}",
            "peak GB": "{peak GB:.2g}",
            "traction error": "{error:.1e}",
            "asked": "{tolerance:.0e}",
            "of a strain flow": "{error of strain flow:.1e}",
        },
    ),
}
