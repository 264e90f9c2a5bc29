"""Tables of the coupled pancake's benchmark."""

from ..view import View

ENDS = r"(?P<model>stokes, implicit|uniform pressure)"
VIEWS = {
    "ends": View(
        ENDS,
        {
            "model": "{model}",
            "seconds": "{seconds:.3g}",
            "pressure at the end": "{pressure:.5g}",
            "error to statics": "{error:.1e}",
            "top": "{top:.5g}",
            "radius": "{radius:.5g}",
            "assemblies a step": "{assemblies/step:.2f}",
            "rejected": "{rejected}",
        },
    ),
    "health": View(
        ENDS,
        {
            "model": "{model}",
            "volume error": "{volume error:.0e}",
            "zeta": "{zeta:.1e}",
            "asymmetry / half width": "{asymmetry/R:.0e}",
            "smallest gap": "{min gap:.3g}",
            "energy defect": "{energy defect:.0e}",
        },
    ),
    "heights": View(
        r"top at V/V0 = (?P<v>.+)",
        {
            "V/V0": "{v}",
            "Stokes flow": "{top:.2f}",
            "uniform pressure": "{top, uniform pressure:.2f}",
            "difference": "{error:.1%}",
        },
    ),
    "schemes": View(
        r"(?P<scheme>[\w-]+), dt = .+",
        {
            "scheme": "{case}",
            "difference to implicit": "{error:.1e}",
            "seconds over implicit": "{ratio:.2f}",
            "assemblies a step": "{assemblies/step:.2f}",
            "rejected": "{rejected}",
            "asymmetry / half width": "{asymmetry/R:.0e}",
        },
    ),
}
