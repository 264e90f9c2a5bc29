"""Tables of the folded bags' benchmark."""

from ..view import View

COARSE = r"mesh\.across=2[46]"  # the meshes of the study of contact's reach
OPENING = rf"opening, (?!.*{COARSE}).*"
VIEWS = {
    "openings": View(
        OPENING,
        {
            "scene": "{scene}",
            "changed": "{changed}",
            "flow": "{model}",
            "rigidity": "{rigidity:.1e}",
            "result": "`{result}`",
            "V/V0 of": "{V/V0:.3g} of {V/V0 asked:.3g}",
            "steps, rejected": "{steps}, {rejected}",
            "seconds": "{seconds:.3g}",
            "volume error": "{error:.0e}",
            "taken from a run of": "{date}",
            "commit": "{commit}",
        },
    ),
    "touching": View(
        OPENING,
        {
            "scene": "{scene}",
            "changed": "{changed}",
            "flow": "{model}",
            "rigidity": "{rigidity:.1e}",
            "frames of states": "{frames} of {states}",
            "crossing": "{crossing}",
            "nearest distance over reach": "{distance/reach:.2f}",
            "contact energy over stored": "{contact energy share:.1e}",
            "panel angle at the end": "{largest angle:.0f}",
            "above uniform pressure, at equal volume": "{angle above:.1f}",
            "at V/V0": "{at V/V0:.2f}",
        },
    ),
    "floors": View(
        rf"opening, .*{COARSE}.*",
        {
            "scene": "{scene}",
            "changed": "{changed}",
            "result": "`{result}`",
            "V/V0": "{V/V0:.3g}",
            "largest pressure": "{largest pressure:.4f}",
            "folds open": "{folds open}",
            "nearest distance over reach": "{distance/reach:.2f}",
            "contact energy over stored": "{contact energy share:.1e}",
            "assemblies a step": "{assemblies a step:.1f}",
            "steps, rejected": "{steps}, {rejected}",
            "seconds": "{seconds:.3g}",
        },
    ),
    "solves": View(
        r"accordion (?P<n>\d+), h2",
        {
            "folds": "{folds}",
            "elements": "{quadrilaterals}",
            "unknowns": "{unknowns}",
            "seconds": "{seconds:.3g}",
            "near, compression, preconditioner, GMRES": (
                "{near:.2g}, {build:.2g}, {preconditioner:.2g}, {gmres:.2g}"
            ),
            "iterations": "{iterations}",
            "bytes an unknown": "{bytes/unknown:.0f}",
            "near pairs a point": "{near pairs/point:.1f}",
            "traction error": "{error:.1e}",
        },
    ),
    "dense": View(
        r"accordion (?P<n>\d+), dense beside it",
        {
            "folds": "{folds}",
            "unknowns": "{unknowns}",
            "seconds": "{seconds:.3g}",
            "iterations": "{iterations}",
            "traction of the compressed solve against it": "{error:.1e}",
        },
    ),
    "growth": View(
        r"growth from (?P<a>\d+) to (?P<b>\d+) folds",
        {
            "folds": "{a} to {b}",
            "bytes": "{exponent of bytes:.2f}",
            "seconds": "{exponent of seconds:.2f}",
            "N log N": "{exponent of N log N:.2f}",
        },
    ),
}
