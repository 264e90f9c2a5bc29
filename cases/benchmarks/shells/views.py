"""Tables of the shells' benchmark."""

from ..view import View

VIEWS = {
    "roof": View(
        r"roof \d+\^2 p=2, (?P<formulation>.+)",
        {
            "formulation": "{formulation}",
            "deflection": "{deflection}",
            "difference to the first": "{difference to first:.1e}",
            "error": "{error:.1e}",
            "seconds": "{seconds:.2g}",
        },
    ),
    "locking": View(
        r"roof h=.*",
        {"degree": "{degree}", "membrane energy": "{rule}"},
        ("h/R = {thickness/radius:g}, {elements}", "{deflection/reference:.4f}"),
    ),
    "rates": View(
        r"roof H2, p=(?P<p>\d), (?P<n>\d+)\^2",
        {"degree": "{p}"},
        ("{n}^2: error (rate)", "{error:.1e} ({rate})"),
    ),
    "rotations": View(
        r"(?P<what>end shear|end moment|slit annulus) (?P<mesh>.+)",
        {
            "case": "{what}",
            "mesh": "{mesh}",
            "against": "{reference}",
            "error": "{error:.1e}",
            "at the end": "{value}",
            "Newton iterations": "{newton}",
            "seconds": "{seconds:.2g}",
        },
    ),
    "spheres": View(
        r"inflated sphere, (?P<law>.+), (?P<n>\d+) rows",
        {"law": "{law}", "stretch": "{stretch}"},
        ("{n} rows", "{error:.1e}"),
    ),
    "cloth": View(
        r"(?P<what>mylar balloon|square airbag|wrinkled strip), (?P<mesh>.+)",
        {
            "case": "{what}",
            "mesh": "{mesh}",
            "against": "{reference}",
            "volume, m or force": "{value}",
            "error": "{error:.1e}",
            "diameter": "{diameter error:.1e}",
            "height": "{height error:.1e}",
            "wrinkled": "{wrinkled:.0%}",
            "slack": "{slack:.0%}",
            "Newton iterations": "{iterations}",
            "seconds": "{seconds:.2g}",
        },
    ),
    "kernels": View(
        r"p=(?P<p>\d), (?P<what>.+)",
        {"": "{what}"},
        ("p = {p}: us an element, times faster", "{us/element:.3g}, {ratio:.3g}"),
    ),
    "solvers": View(
        r"tangent of (?P<n>\d+)\^2 elements, p=2, direct",
        {
            "unknowns": "{unknowns}",
            "direct, seconds": "{seconds:.2g}",
            "pyamg + CG, seconds": "{peer seconds:.2g}",
            "ratio": "{ratio:.2g}",
            "residuals": "{error:.0e}, {peer error:.0e}",
        },
    ),
    "reuse": View(
        r"path of (?P<n>\d+)\^2 elements, p=3, factor kept",
        {
            "elements": "{n}^2",
            "factors": "{factors}",
            "seconds": "{seconds:.2g}",
            "times faster": "{ratio:.2g}",
            "difference": "{error:.0e}",
        },
    ),
}
